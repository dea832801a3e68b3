"""Reads generated training data with NumPy alone."""

import os
import tarfile
from collections.abc import Iterator
from pathlib import Path

from datasets_gen.records import InputError
from evaluation.generation.sample_plan import SPLITS
from evaluation.generation.training_sample import TrainingSample


def read_shards(folder: str | os.PathLike[str], split: str | None = None) -> Iterator[TrainingSample]:
    """Samples of a folder that `medialbench generate` made, in the order of its shards, one at a time.

    Parameters
    ----------
    folder
    split
        ``"train"`` or ``"val"``; None for both.

    Raises
    ------
    InputError
        If the split is unknown, the folder holds no shard of it, or a shard is damaged.
    """
    if split not in (None, *SPLITS):
        raise InputError(f"split is {split!r}; choose {' or '.join(SPLITS)}, or leave it out for both")
    paths = [
        path
        for name in SPLITS
        if split in (None, name)
        for path in sorted(Path(folder).glob(f"{name}-*.tar"))
    ]
    if not paths:
        raise InputError(
            f"{str(folder)!r} holds no shards of {split or 'training data'}; medialbench generate makes them"
        )
    for path in paths:
        yield from read_shard(path)


def read_shard(path: str | os.PathLike[str]) -> Iterator[TrainingSample]:
    """Samples of one shard, in order.

    Parameters
    ----------
    path
        Of the tar file.

    Raises
    ------
    InputError
        If it is missing or damaged.
    """
    key, members = "", dict[str, bytes]()
    try:
        with tarfile.open(path, "r:") as archive:
            for entry in archive:
                start, _, suffix = entry.name.partition(".")
                stream = archive.extractfile(entry)
                if start != key and members:
                    yield TrainingSample.of_members(key, members)
                    members = {}
                key, members[suffix] = start, stream.read() if stream else b""
        if members:
            yield TrainingSample.of_members(key, members)
    except (OSError, tarfile.TarError) as error:
        raise InputError(f"{str(path)!r} is no readable shard ({error}); make it again") from error
    except InputError as error:
        raise InputError(f"{str(path)!r}: {error}") from error
