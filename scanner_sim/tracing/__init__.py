"""Rays with Mitsuba: variants, scenes, materials, brute-force rendering."""
