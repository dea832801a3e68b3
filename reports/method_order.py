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
    "skeleton": "#a6761d",
    "rigid": "#8c8c8c",
    "truth": "#24292f",
}
"""Colours of methods by the beginning of their labels (Okabe & Ito 2008)."""


def order_methods(methods: Iterable[str]) -> list[str]:
    """Labels in the order of `METHODS`, the shorter of one method first; unknown ones last, by alphabet."""
    known = list(METHODS)

    def rank(label: str) -> tuple[int, int, str]:
        name = known_method(label)
        return (known.index(name), len(label), label) if name else (len(known), 0, label)

    return sorted(set(methods), key=rank)


def known_method(label: str) -> str:
    """The known method that a label begins with, such as "medial" for "medial diffusion"; empty if none."""
    return next((name for name in METHODS if label.lower().startswith(name)), "")
