"""Methods by the beginning of their labels: order and colours, the same in every table and figure."""

from collections.abc import Iterable

METHODS = {
    "medial": "#d55e00",
    "heat": "#0072b2",
    "robust": "#009e73",
    "tufted": "#009e73",
    "functional": "#cc79a7",
    "cpd": "#e69f00",
    "geodesic": "#56b4e9",
    "rigid": "#8c8c8c",
    "truth": "#24292f",
}
"""Colours of methods by the beginning of their labels (Okabe & Ito 2008)."""


def order_methods(methods: Iterable[str]) -> list[str]:
    """Labels in the order of `METHODS`, the unknown ones last; the shorter first, then by the alphabet."""
    known = [*METHODS, ""]
    return sorted(set(methods), key=lambda label: (known.index(known_method(label)), len(label), label))


def known_method(label: str) -> str:
    """The known method that a label begins with, such as "medial" for "medial diffusion"; empty if none."""
    return next((name for name in METHODS if label.lower().startswith(name)), "")
