"""Correspondence methods behind one interface.

Read `base` (what a method gets and returns), then `catalogue` (names to classes), then the methods:
`spectral` (medial diffusion and its baselines), `ceiling`, `functional` (with `gradients`), `geodesic_graph`,
`rigid`, `cpd`, `external`. A new method is one more file and one more line of the catalogue; a change in
one method changes the results of no other.
"""

from evaluation.methods.base import Method, MethodInput, dense
from evaluation.methods.catalogue import METHODS, create, find, missing

__all__ = ["METHODS", "Method", "MethodInput", "create", "dense", "find", "missing"]
