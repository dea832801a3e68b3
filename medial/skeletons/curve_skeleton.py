"""The result: a graph of curves through the middle of a body, and which of its points belong where."""

import os
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from datasets_gen.record_arrays import check_ids, check_layout, check_values
from datasets_gen.records import load_record, save_record, unpacking

Float = NDArray[np.float64]
Int = NDArray[np.int64]

KINDS = ("alone", "tip", "inner", "joint")
"""Kind of a node by its number of edges; a joint has three or more."""
_LAYOUT = {"nodes": "float k 3", "radii": "float k", "edges": "int e 2", "node_of_point": "int n"}


@dataclass(frozen=True)
class CurveSkeleton:
    """A curve skeleton of a cloud; a forest, or with loops around handles.

    Attributes
    ----------
    nodes : (k, 3) float64
        In the units of the cloud.
    edges : (e, 2) int64
        Pairs of nodes.
    radii : (k,) float64
        Of the body around each node.
    node_of_point : (n,) int64
        Node of every point of the cloud; -1 for one that belongs to none, as on a sheet.
    method : str
        ``"rosa"``, ``"medial"`` or ``"local-separators"``.
    reason : str
        Why there is no curve, if there is none; empty otherwise.
    """

    nodes: Float
    edges: Int
    radii: Float
    node_of_point: Int
    method: str = ""
    reason: str = ""

    @classmethod
    def empty(cls, points: int, method: str, reason: str) -> "CurveSkeleton":
        """A skeleton without nodes of a cloud of some points, with the reason."""
        none = np.full(points, -1, dtype=np.int64)
        return cls(np.zeros((0, 3)), np.zeros((0, 2), np.int64), np.zeros(0), none, method, reason)

    def __len__(self) -> int:
        """Return the number of nodes."""
        return len(self.nodes)

    def __repr__(self) -> str:
        """One line: method, nodes, tips, joints and parts."""
        if not len(self.edges):
            return f"CurveSkeleton({self.method}: {len(self)} nodes, no curve: {self.reason})"
        tips, joints = (int((self.kinds == kind).sum()) for kind in ("tip", "joint"))
        parts = len(np.unique(self.components))
        return f"CurveSkeleton({self.method}: {len(self)} nodes, {tips} tips, {joints} joints, {parts} parts)"

    @cached_property
    def degrees(self) -> Int:
        """Edges at each node, (k,)."""
        return np.bincount(self.edges.ravel(), minlength=len(self)).astype(np.int64)

    @cached_property
    def kinds(self) -> NDArray[np.str_]:
        """Kind of each node, (k,): one of `KINDS`."""
        return np.array(KINDS)[np.minimum(self.degrees, len(KINDS) - 1)]

    @cached_property
    def components(self) -> Int:
        """Connected part of each node, (k,), numbered from 0."""
        if not len(self):
            return np.zeros(0, np.int64)
        a, b = self.edges.T
        graph = coo_array((np.ones(len(a)), (a, b)), shape=(len(self), len(self)))
        return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)

    @property
    def lengths(self) -> Float:
        """Length of each edge, (e,)."""
        a, b = self.nodes[self.edges[:, 0]], self.nodes[self.edges[:, 1]]
        return np.asarray(np.linalg.norm(a - b, axis=1))

    @property
    def loops(self) -> int:
        """Number of independent loops."""
        parts = len(np.unique(self.components))
        return len(self.edges) - len(self) + parts

    def branches(self) -> list[Int]:
        """Chains of nodes between tips and joints, each once; a ring begins and ends at one node."""
        around: list[list[int]] = [[] for _ in range(len(self))]
        for a, b in self.edges:
            around[a].append(int(b))
            around[b].append(int(a))
        found: list[Int] = []
        used: set[tuple[int, int]] = set()
        ends = [k for k in range(len(self)) if self.degrees[k] not in (0, 2)]
        for start in [*ends, *np.flatnonzero(self.degrees == 2)]:  # what is left then are rings
            for onward in around[start]:
                if (start, onward) in used:
                    continue
                chain = [int(start), onward]
                while self.degrees[chain[-1]] == 2 and chain[-1] != start:
                    a, b = around[chain[-1]]
                    chain.append(b if a == chain[-2] else a)
                used.update(pairwise(chain))
                used.update(pairwise(chain[::-1]))
                found.append(np.array(chain, dtype=np.int64))
        return found

    def sampled(self, step: float) -> tuple[Float, Int, Float]:
        """Places on the edges, no more than a step apart, both ends of every edge among them.

        Parameters
        ----------
        step
            In the units of the cloud, above 0.

        Returns
        -------
        places : (s, 3) float64
        edge : (s,) int64
        share : (s,) float64
            Of the way from the first node of the edge to the second.
        """
        counts = np.maximum(np.ceil(self.lengths / step).astype(np.int64), 1) + 1
        edge = np.repeat(np.arange(len(self.edges)), counts)
        first = np.repeat(np.cumsum(counts) - counts, counts)
        share = (np.arange(len(edge)) - first) / (np.repeat(counts, counts) - 1)
        a, b = self.nodes[self.edges[edge, 0]], self.nodes[self.edges[edge, 1]]
        return a + share[:, None] * (b - a), edge, share

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a ``.npz``, which `load` reads."""
        arrays = {name: getattr(self, name) for name in _LAYOUT}
        save_record(path, "CurveSkeleton", arrays, {"method": self.method, "reason": self.reason})

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> "CurveSkeleton":
        """Read what `save` wrote.

        Raises
        ------
        InputError
            If it is no such file, or arrays in it do not fit each other.
        """
        arrays, meta = load_record(path, "CurveSkeleton")
        with unpacking(path, "CurveSkeleton"):
            count = check_layout(arrays, _LAYOUT, finite="nodes radii")["k"]
            check_ids(arrays["edges"], count, "edges")
            check_ids(arrays["node_of_point"], count, "node_of_point", -1)
            check_values(cls, meta)
            return cls(**arrays, **meta)
