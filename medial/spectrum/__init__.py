"""The smallest modes of an operator."""
