"""Shapes with ground truth: built-in bodies, generated bodies and folders of posed meshes."""

from datasets_gen.records import InputError
from datasets_gen.shape import Collection, Shape

__all__ = ["Collection", "InputError", "Shape"]
