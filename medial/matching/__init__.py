"""Matching of two clouds (Sec. 4 and beyond)."""
