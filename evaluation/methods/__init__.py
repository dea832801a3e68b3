"""Correspondence methods behind one interface."""

from evaluation.methods.base import Cloud, Method, dense
from evaluation.methods.registry import METHODS, create, find, missing

__all__ = ["METHODS", "Cloud", "Method", "create", "dense", "find", "missing"]
