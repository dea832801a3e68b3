"""Medial similarity (Eqs. 4-7)."""
