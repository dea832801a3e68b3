"""What ``medialbench run`` is told to run: a preset, a TOML file or a results folder."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from reports.cli.console import Failure

if TYPE_CHECKING:
    from evaluation import Experiment
    from evaluation.experiment.config_sections import MethodSection

FILE = "experiment.toml"


def load_experiment(
    name: str,
    datasets: tuple[str, ...] = (),
    seeds: int | None = None,
    poses: str | None = None,
    methods: tuple[str, ...] = (),
) -> "Experiment":
    """An experiment, with other data sets, which follow its rule of poses, other seeds, poses and methods.

    Parameters
    ----------
    name
        Of a preset, of a TOML file, or of a results folder.
    datasets
        Use these instead of the experiment's.
    seeds
        Use the seeds 0 to ``seeds - 1`` instead of the experiment's.
    poses
        A number, ``"all"`` or names with commas between them, for every data set.
    methods
        Labels or names of those of its methods to use.

    Raises
    ------
    Failure
        If it is a folder of something else, or has no such method.
    InputError
        If there is no such preset or file, or its contents cannot be used.
    """
    from dataclasses import replace

    from datasets_gen.registry import is_folder
    from evaluation.experiment.config_sections import DatasetSection
    from evaluation.experiment.experiment import Experiment

    _check_folder(name)
    folder = results_of(name)
    experiment = Experiment.load(name if folder is None else folder / FILE)
    if seeds is not None:
        experiment = replace(experiment, seeds=tuple(range(seeds)))
    chosen: Any = poses
    if poses is not None and poses != "all":
        chosen = (
            int(poses) if poses.lstrip("-").isdigit() else tuple(each.strip() for each in poses.split(","))
        )
    if datasets:
        rule = experiment.dataset[0].poses
        rule = "all" if isinstance(rule, tuple) else rule
        located = [str(Path(each).resolve()) if is_folder(each) else each for each in datasets]
        sections = tuple(DatasetSection(name=each, poses=rule) for each in located)
        experiment = replace(experiment, dataset=sections)
    if poses is not None:
        sections = tuple(replace(each, poses=chosen) for each in experiment.dataset)
        experiment = replace(experiment, dataset=sections)
    return replace(experiment, method=_chosen(experiment, methods)) if methods else experiment


def _chosen(experiment: "Experiment", wanted: tuple[str, ...]) -> "tuple[MethodSection, ...]":
    """The methods whose label is wanted, or whose name where it is no method's label; in their order."""
    labels = [each.label for each in experiment.method]
    for each in wanted:
        if each not in labels and each not in [method.name for method in experiment.method]:
            known = ", ".join(repr(label) for label in labels) or "none"
            raise Failure(f"{experiment.name!r} has no method {each!r}; it has {known}")
    by_name = [each for each in wanted if each not in labels]
    return tuple(each for each in experiment.method if each.label in wanted or each.name in by_name)


def results_of(name: str) -> Path | None:
    """The results folder that is meant; None for a preset or a TOML file."""
    from evaluation.experiment.presets import presets

    folder = Path(name)
    return folder if name not in presets() and (folder / FILE).is_file() else None


def check_experiment_kept(name: str, experiment: "Experiment", folder: Path) -> None:
    """Raise Failure if a run would overwrite the TOML file that it was given with another text.

    A run writes its experiment, every setting spelled out, as ``experiment.toml`` into its folder. In a
    folder that holds results the file is the run's own.
    """
    written = folder / FILE
    if not Path(name).is_file() or not written.exists() or not written.samefile(name):
        return
    if (folder / "run.json").is_file() or written.read_text(encoding="utf-8") == experiment.to_toml():
        return
    raise Failure(f"a run in {str(folder)!r} would overwrite its input {name!r}; choose another -o")


def _check_folder(name: str) -> None:
    """Raise Failure for a folder that holds no experiment, with what to do about it."""
    from datasets_gen import MESH_SUFFIXES
    from evaluation.experiment.presets import presets

    folder, known = Path(name), presets()
    if name in known or not folder.is_dir() or (folder / FILE).is_file():
        return
    if any(each.suffix.lower() in MESH_SUFFIXES for each in folder.iterdir()):
        raise Failure(
            f"{name!r} is a folder of meshes, not an experiment; "
            f"scan and match them with: medialbench run quick --dataset {name}"
        )
    raise Failure(f"folder {name!r} holds no {FILE}; give one that does, or a preset: {', '.join(known)}")
