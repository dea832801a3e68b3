"""One scan with its ground truth, and its files in a shard."""

import io
import json
import tarfile
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets_gen.parsing import parsed_json
from datasets_gen.record_arrays import check_layout
from datasets_gen.records import InputError

LAYOUT = {
    **dict.fromkeys(("points", "normals", "true_points", "canonical", "barycentrics"), "float n 3"),
    "intensity": "float n",
    "face_ids": "int n",
    "view_ids": "int n",
}
"""Arrays of a sample (`datasets_gen.record_arrays`)."""


@dataclass(frozen=True, repr=False)
class TrainingSample:
    """One scan with its ground truth.

    Attributes
    ----------
    key : str
        ``"train-00000012"``: the split and the number in it.
    points : (n, 3) float32
        Measured positions, in the units and the frame of the scanned body.
    normals : (n, 3) float32
        Unit, outward.
    true_points : (n, 3) float32
        Where the ray hit the surface: the noise is ``points - true_points``.
    canonical : (n, 3) float32
        The same places of the surface on the reference pose: equal places of two samples of one data set have
        equal canonical coordinates.
    face_ids : (n,) int32
        Face of the reference mesh in which each place lies.
    barycentrics : (n, 3) float32
        Where in that face.
    intensity : (n,) float32
        Fitted peak of the laser line, at least the threshold.
    view_ids : (n,) int32
        Viewpoint that measured each point; -1 for a mesh that was sampled without the scanner.
    about : mapping
        Data set, subject, pose, seeds, threshold, viewpoints, missing share (docs/training-data.md).
    """

    key: str
    points: NDArray[np.float32]
    normals: NDArray[np.float32]
    true_points: NDArray[np.float32]
    canonical: NDArray[np.float32]
    face_ids: NDArray[np.int32]
    barycentrics: NDArray[np.float32]
    intensity: NDArray[np.float32]
    view_ids: NDArray[np.int32]
    about: Mapping[str, Any]

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.points)

    def __repr__(self) -> str:
        """One line: key, body, pose and size."""
        about = f"{self.about.get('individual')} {self.about.get('pose')}"
        return f"TrainingSample({self.key!r}: {about}, {len(self):,} points)"

    def members(self) -> dict[str, bytes]:
        """Content of the files of this sample, by the part of their names after the key."""
        found = {f"{name}.npy": _npy(getattr(self, name)) for name in LAYOUT}
        return found | {"json": (json.dumps(self.about, sort_keys=True, indent=1) + "\n").encode()}

    def write(self, archive: tarfile.TarFile) -> None:
        """Append the files, without time and owner: same sample, same bytes."""
        for suffix, content in self.members().items():
            entry = tarfile.TarInfo(f"{self.key}.{suffix}")
            entry.size, entry.mode = len(content), 0o644
            archive.addfile(entry, io.BytesIO(content))

    @classmethod
    def of_members(cls, key: str, members: Mapping[str, bytes]) -> "TrainingSample":
        """The sample of what `members` gives.

        Raises
        ------
        InputError
            If a file is missing or damaged.
        """
        about = parsed_json(members.get("json", b""), f"{key}.json")
        try:
            if not isinstance(about, dict):
                raise ValueError("its JSON file holds no table")
            arrays = {name: _array(members, f"{name}.npy") for name in LAYOUT}
            check_layout(arrays, LAYOUT, finite="points canonical")
        except (ValueError, EOFError, OSError) as error:
            raise InputError(f"sample {key!r} is damaged ({error}); make its shard again") from error
        return cls(key=key, about=about, **arrays)


def _npy(array: NDArray[Any]) -> bytes:
    stream = io.BytesIO()
    np.lib.format.write_array(stream, np.ascontiguousarray(array), version=(1, 0), allow_pickle=False)
    return stream.getvalue()


def _array(members: Mapping[str, bytes], name: str) -> NDArray[Any]:
    if name not in members:
        raise ValueError(f"{name} is missing")
    array: NDArray[Any] = np.lib.format.read_array(io.BytesIO(members[name]), allow_pickle=False)
    return array
