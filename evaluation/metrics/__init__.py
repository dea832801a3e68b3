"""Errors of maps and of operators."""
