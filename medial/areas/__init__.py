"""Medial axis (Eq. 9) and areas (Eq. 10)."""
