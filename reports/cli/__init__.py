"""Command line ``medialbench``: one module per command."""
