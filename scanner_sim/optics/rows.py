"""Rows of samples: the intensities of pixels under consecutive stripes."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scanner_sim.optics.stripe import SweptStripes

LARGEST_BLOCK = 4_000_000
"""Samples that are held as one padded array."""


@dataclass(frozen=True)
class Rows:
    """Rows of different lengths, one after the other.

    Attributes
    ----------
    first, stop : (n,) int64
        Number of the first stripe of each row, and of the one after its last.
    values : (s,) float64
        Samples of all rows; s is the sum of ``stop - first``.
    """

    first: NDArray[np.int64]
    stop: NDArray[np.int64]
    values: NDArray[np.float64]

    @classmethod
    def uniform(cls, swept: SweptStripes) -> "Rows":
        """Rows of one length."""
        return cls(swept.first, swept.first + swept.values.shape[1], swept.values.ravel())

    @classmethod
    def gathered(
        cls, row: NDArray[np.integer], count: int, swept: SweptStripes, weights: NDArray[np.float64]
    ) -> "Rows":
        """Sums of weighted stripes that belong to the same row.

        Parameters
        ----------
        row : (k,)
            Row of each of k surface points.
        count
            Number of rows n; each has at least one point.
        swept
            Stripes of each point, (k, w).
        weights : (k,)
        """
        width = swept.values.shape[1]
        first = np.full(count, np.iinfo(np.int64).max)
        stop = np.full(count, np.iinfo(np.int64).min)
        np.minimum.at(first, row, swept.first)
        np.maximum.at(stop, row, swept.first + width)
        start = np.concatenate([[0], np.cumsum(stop - first)])
        place = (start[row] + swept.first - first[row])[:, None] + np.arange(width)
        light = swept.values * weights[:, None]
        sums = np.bincount(place.ravel(), light.ravel(), minlength=int(start[-1]))
        return cls(first, stop, sums.astype(np.float64))

    @property
    def start(self) -> NDArray[np.int64]:
        """Where each row begins among the values, (n,)."""
        return np.cumsum(self.stop - self.first) - (self.stop - self.first)

    def stripes(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Row and stripe of every sample, (s,) each."""
        length = self.stop - self.first
        row = np.repeat(np.arange(len(length)), length)
        return row, np.arange(len(self.values)) - np.repeat(self.start - self.first, length)

    def largest(self) -> NDArray[np.float64]:
        """Largest sample of each row, (n,); no row may be empty."""
        return np.maximum.reduceat(self.values, self.start) if len(self.first) else np.empty(0)

    def brightest_runs(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """First stripe and the one after the last of each row's brightest run of lit samples, (n,) each."""
        row, stripe = self.stripes()
        if len(row) == 0:
            return self.first, self.stop
        lit = self.values > 0
        begins = lit & np.concatenate([[True], ~lit[:-1] | (row[1:] != row[:-1])])
        run = np.cumsum(begins) - 1  # of lit samples
        order = np.lexsort((-self.values, row))
        place = np.searchsorted(row[order], np.arange(len(self.first)))
        top = order[np.minimum(place, len(order) - 1)]
        low = np.flatnonzero(begins)
        high = np.zeros(len(low), np.int64)
        np.maximum.at(high, run[lit], stripe[lit] + 1)
        empty = ~lit[top] | (self.stop == self.first)
        own = np.where(empty, 0, run[top])
        first, stop = stripe[low][own] if len(low) else self.first, high[own] if len(low) else self.stop
        return np.where(empty, self.first, first), np.where(empty, self.stop, stop)

    def cut(self, first: NDArray[np.int64], stop: NDArray[np.int64]) -> "Rows":
        """Rows without what lies outside the given stripes, which lie within them, (n,) each."""
        row, stripe = self.stripes()
        return Rows(first, stop, self.values[(stripe >= first[row]) & (stripe < stop[row])])

    def select(self, index: NDArray[np.integer]) -> "Rows":
        """Some of the rows, in the order of the index."""
        length = (self.stop - self.first)[index]
        shift = np.repeat(self.start[index] - (np.cumsum(length) - length), length)
        return Rows(self.first[index], self.stop[index], self.values[np.arange(int(length.sum())) + shift])

    def blocks(self) -> Iterator[NDArray[np.int64]]:
        """Rows of similar length, in index arrays that fit in memory as one padded array each."""
        length = self.stop - self.first
        if len(length) == 0:
            return
        if length.min() == length.max():
            classes = np.zeros(len(length), np.int64)
        else:
            classes = np.ceil(np.log2(np.maximum(length, 1))).astype(np.int64)
        for each in np.unique(classes):
            members = np.flatnonzero(classes == each)
            parts = max(1, int(np.ceil(len(members) * length[members].max() / LARGEST_BLOCK)))
            yield from np.array_split(members, parts)

    def padded(self, index: NDArray[np.integer]) -> NDArray[np.float64]:
        """Rows of an index side by side, (m, w), with zeros after the shorter ones."""
        length = (self.stop - self.first)[index]
        width = int(length.max(initial=0))
        if len(self.values) == len(self.first) * width == len(index) * width:  # all rows, of one length
            return self.values.reshape(len(self.first), width)[index]
        column = np.arange(width)
        inside = column < length[:, None]
        place = np.where(inside, self.start[index][:, None] + column, 0)
        return np.where(inside, self.values[place], 0.0)
