"""Deform one cloud onto the other and judge the fit."""
