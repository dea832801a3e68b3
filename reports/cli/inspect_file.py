"""``medialbench inspect``: what is in a file of a cloud or a mesh, and what match and scan make of it."""

import json
import logging
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from reports.cli.console import PACKAGES, Command
from reports.cli.map_options import POINTS
from reports.cli.progress import steps

if TYPE_CHECKING:
    from datasets_gen import Shape
    from datasets_gen.clouds.point_cloud import PointCloud
    from scanner_sim import Scan

Facts = dict[str, Any]

STEPS = (("reading", 2), ("measuring", 3), ("normals", 4))


@click.command(cls=Command, short_help="Look at a cloud or a mesh before it is matched or scanned.")
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--json", "as_json", is_flag=True, help="Print all of it as JSON.")
@click.option(
    "--columns",
    metavar='"x y z nx ny nz"',
    help="Names of the columns of a text; - for one to leave out.  [default: told by the file]",
)
def inspect(file: Path, as_json: bool, columns: str | None, quiet: bool) -> None:
    """Show what is in FILE: a scan, a cloud or a mesh.

    Points, spacing, groups, copies and strays, how finely coordinates are given, which unit they may have,
    whether normals point outward and how much of the surface may be missing; of a mesh, what is wrong with
    it. Then what match and scan would do with the file, and warn of. Estimates say so.
    """
    with steps(quiet, STEPS) as step:
        next(step)
        with collected() as remarks:
            from reports.cli.cloud_files import read_content

            content = read_content(file, columns)
        next(step)
        facts = facts_of(content, remarks, file, lambda: next(step))
    click.echo(json.dumps(facts, indent=2) if as_json else "\n".join(lines_of(facts)))


def facts_of(
    content: "Scan | Shape | PointCloud", remarks: list[str], file: Path, going_on: Any = lambda: None
) -> Facts:
    """All that is said of a file, in values that JSON can hold.

    Parameters
    ----------
    content
        What `cloud_files.read_content` gave.
    remarks
        What was said on reading it.
    file
    going_on
        Called before normals are looked at.

    Raises
    ------
    InputError
        If there is no finite point, or one beyond what can be computed with.
    """
    import numpy as np

    from datasets_gen import Shape
    from datasets_gen.clouds.cleaning import check_extent
    from datasets_gen.clouds.measures import measure_cloud
    from datasets_gen.clouds.mesh_measures import measure_mesh
    from scanner_sim import Scan

    kind = "mesh" if isinstance(content, Shape) else "scan" if isinstance(content, Scan) else "cloud"
    points = content.vertices if isinstance(content, Shape) else content.points
    finite = points[np.isfinite(points).all(axis=1)]
    check_extent(finite, repr(str(file)))
    facts: Facts = {"file": str(file), "kind": kind, "remarks": remarks}
    measured = measure_cloud(finite)
    facts["points"] = _plain(asdict(measured))
    facts["points"]["rounding"]["said"] = measured.rounding.words()
    if isinstance(content, Shape):
        faces = content.faces
        in_range = not len(faces) or (faces.min() >= 0 and faces.max() < len(points))
        if in_range and len(finite) == len(points):
            facts["mesh"] = _plain(asdict(measure_mesh(points, faces)))
    going_on()
    facts |= _for_matching(content, file, facts.get("mesh"))
    facts["scan"] = _for_scanning(content)
    return facts


def _for_matching(content: "Scan | Shape | PointCloud", file: Path, mesh: Facts | None) -> Facts:
    """Normals, what may be missing, and what match would do."""
    from datasets_gen import InputError, Shape
    from datasets_gen.clouds.cleaning import lacking_normals
    from medial.outward import outward_share
    from medial.places import distinct_places
    from reports.cli.cloud_files import ThinnedCloud, as_scan

    given = None if isinstance(content, Shape) else content.normals
    lacking = 0 if given is None else int(lacking_normals(given).sum())
    source = "of the faces" if isinstance(content, Shape) else "given"
    if not isinstance(content, Shape) and (given is None or lacking == len(given)):
        source, lacking = "estimated", 0
    normals: Facts = {"source": source, "lacking": lacking, "outward": None}
    missing: Facts = {"share": None, "how": "not estimated: the file cannot be matched"}
    try:
        with collected() as said:
            cloud = ThinnedCloud.of(as_scan(content, file, POINTS), POINTS, name=repr(str(file)))
            scan = cloud.scan
            normals["outward"] = round(outward_share(scan.points, _unit(scan.normals)), 3)
            places = distinct_places(scan.points, scan.normals)
    except InputError as error:
        return {"normals": normals, "missing": missing, "match": {"refused": str(error), "warnings": said}}
    missing = _missing(places.cloud.points, places.cloud.normals, source, mesh)
    match = {"refused": None, "matched": len(scan), "of": len(cloud.points), "warnings": said}
    return {"normals": normals, "missing": missing, "match": match}


def _unit(normals: Any) -> Any:
    import numpy as np

    return normals / np.linalg.norm(normals, axis=1, keepdims=True)


def _missing(points: Any, normals: Any, source: str, mesh: Facts | None) -> Facts:
    """The share of the surface that is missing, as far as it can be told."""
    from datasets_gen.clouds.measures import missing_share

    if mesh and not mesh["boundary_edges"]:
        return {"share": 0.0, "how": "the mesh is closed"}
    if mesh and mesh["pieces"] > 1:
        return {"share": None, "how": "not estimated: several pieces, of which some may be no body"}
    share = missing_share(points, normals)
    if share is None:
        return {"share": None, "how": "not estimated: the normals do not all point outward"}
    how = "give or take 20: were this one closed body, by what each point sees of it from within"
    if source == "estimated":
        how += ", less sure here as normals are estimated"
    return {"share": round(share, 2), "how": how}


def _for_scanning(content: "Scan | Shape | PointCloud") -> Facts:
    """What scan would do."""
    from datasets_gen import InputError, Shape
    from datasets_gen.checks import check_mesh, scannable

    if not isinstance(content, Shape):
        return {"refused": "a cloud has no faces; scan needs a mesh", "warnings": [], "truth": None}
    try:
        with collected() as said:
            shape = scannable(content)
    except InputError as error:
        return {"refused": str(error), "warnings": [], "truth": None}
    try:
        check_mesh(shape)
    except InputError as error:
        return {"refused": None, "warnings": said, "truth": str(error).replace("repair=True", "--repair")}
    return {"refused": None, "warnings": said, "truth": "ok"}


@contextmanager
def collected() -> Iterator[list[str]]:
    """The project's own warnings within the context, instead of on the terminal."""
    lines: list[str] = []

    class Lines(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            if record.name.partition(".")[0] in PACKAGES and record.levelno >= logging.WARNING:
                lines.append(record.getMessage())

    root = logging.getLogger()
    before, level, root.handlers = root.handlers, root.level, [Lines()]
    root.setLevel(logging.WARNING)
    try:
        yield lines
    finally:
        root.handlers = before
        root.setLevel(level)


def _plain(value: Any) -> Any:
    """Values that JSON can hold; infinity is None."""
    if isinstance(value, dict):
        return {name: _plain(each) for name, each in value.items()}
    if hasattr(value, "tolist"):  # arrays and numbers of NumPy
        return _plain(value.tolist())
    if isinstance(value, list):
        return [_plain(each) for each in value]
    if isinstance(value, float):
        return float(f"{value:.9g}") if isfinite(value) else None
    return value


def lines_of(facts: Facts) -> list[str]:
    """The facts for people, one line each."""
    cloud = facts["points"]
    rows = [("file", f"{facts['file']} ({facts['kind']})"), *_said_of_points(cloud)]
    if facts["kind"] == "mesh":  # of its vertices, groups say nothing
        rows = [row for row in rows if row[0] != "groups"] + _said_of_mesh(facts.get("mesh"))
    normals = facts["normals"]
    share = normals["outward"]
    outward = "side unknown" if share is None else f"{100 * share:.0f} % look outward"
    lacking = f", {normals['lacking']:,} zero or NaN" if normals["lacking"] else ""
    rows.append(("normals", f"{normals['source']}{lacking}; {outward}"))
    missing = facts["missing"]
    about = "" if missing["share"] is None else f"about {100 * missing['share']:.0f} %, "
    rows.append(("missing", about + missing["how"]))
    rows += [("remark", line) for line in facts["remarks"]]
    match, scan = facts["match"], facts["scan"]
    kind = "samples of the surface" if facts["kind"] == "mesh" else "points"
    done = match["refused"] or (
        f"takes {match['matched']:,} of {match['of']:,} {kind}"
        if match["matched"] < match["of"]
        else f"takes {match['of']:,} {kind}"
    )
    rows += [("match", done), *(("match warns", line) for line in match["warnings"])]
    rows += [("scan", scan["refused"] or "can scan it"), *(("scan warns", line) for line in scan["warnings"])]
    if scan["truth"] not in (None, "ok"):
        rows.append(("as ground truth", scan["truth"]))
    return [f"{name + ':':<17}{text}" for name, text in rows]


def _said_of_points(cloud: Facts) -> list[tuple[str, str]]:
    low, high = (" ".join(f"{value:.6g}" for value in cloud[name]) for name in ("low", "high"))
    middle, near, far = (f"{value:.3g}" for value in cloud["spacing"])
    rows = [
        ("points", f"{cloud['points']:,}"),
        ("bounding box", f"{low}  to  {high}"),
        ("spacing", f"{middle} (median; the middle 90 %: {near} to {far})"),
        ("groups", f"{cloud['groups']:,} more than five spacings apart"),
        ("copies", f"{cloud['copies']:,} points at the place of another"),
        ("stray points", f"{cloud['stray']:,}"),
        ("precision", cloud["rounding"]["said"] or "finer than the points' distances"),
    ]
    guess = f"{cloud['units']}, a guess from the size, as of a person or an animal" if cloud["units"] else ""
    return [*rows, ("unit", guess or "unknown: the size fits no person or animal in m, cm or mm")]


def _said_of_mesh(mesh: Facts | None) -> list[tuple[str, str]]:
    if mesh is None:
        return [("faces", "not measured: some name vertices that are not there, or are not finite")]
    rims = f"{mesh['boundary_loops']:,} ({mesh['boundary_edges']:,} edges)"
    caps = ""
    if mesh["caps"]:
        caps = f"; flat caps over them would be {100 * mesh['caps']:.1f} % of the surface"
    conflicts = mesh["winding_conflicts"]
    wound = f"{conflicts:,} edges have faces wound against each other" if conflicts else "consistent"
    return [
        ("vertices", f"{mesh['vertices']:,}, {mesh['unreferenced']:,} of no face"),
        (
            "faces",
            f"{mesh['faces']:,}, {mesh['degenerate']:,} without area, {mesh['repeated']:,} repeated",
        ),
        ("pieces", f"{mesh['pieces']:,}"),
        ("boundaries", rims + caps),
        ("crowded edges", f"{mesh['crowded_edges']:,} of more than two faces"),
        ("winding", wound + (", inward" if mesh["inward"] else "")),
    ]
