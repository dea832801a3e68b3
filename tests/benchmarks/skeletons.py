"""Curve skeletons against medial diffusion, as data goes missing: the comparison of the paper's Fig. 10.

    python -m tests.benchmarks.skeletons [--bodies human,quadruped,hand] [--only matching] [-o FILE.csv]
    python -m tests.benchmarks.skeletons --growth 1000 2000 4000 8000

Scans of two poses at three peak thresholds; each seed is another second pose and other noise. Local
separators take part where `pygel3d` is installed. Prints Markdown tables; ``-o`` keeps the rows.
"""

import argparse
import sys
import time
from pathlib import Path

import numpy as np
import pandas as pd

import datasets_gen
import scanner_sim
from datasets_gen.records import InputError
from evaluation.methods import MethodInput, create
from evaluation.metrics.skeleton_score import skeleton_score
from evaluation.metrics.skeleton_truth import known_bones
from medial import Diffusion
from medial.skeletons import SKELETON_METHODS, skeleton_of
from scanner_sim import ScannerConfig
from tests.benchmarks.operator_stages import scanned

BODIES = ("human", "quadruped", "hand")
THRESHOLDS = (0.3, 0.8, 0.9)
VIEWS = 6
MATCHERS = {
    "medial diffusion": ("medial", {}),
    "skeleton (rosa)": ("skeleton", {"skeleton": "rosa"}),
    "skeleton (medial)": ("skeleton", {"skeleton": "medial"}),
}


def timed(function, *arguments):
    """Result of a call, and its processor seconds: others may share the machine."""
    start = time.process_time()
    return function(*arguments), time.process_time() - start


def extracted(scan, bones, area):
    """Rows of all skeletons of a scan."""
    for method in SKELETON_METHODS:
        try:
            found, seconds = timed(skeleton_of, scan.points, scan.normals, method)
        except InputError as error:  # a package is missing
            sys.stderr.write(f"{error}\n")
            continue
        score = skeleton_score(found, bones, area)
        yield {"skeleton": method, "seconds": seconds, "right": score.right, **vars(score)}


def matched(scans, truth, area, seed):
    """Rows of all methods on a pair; errors are straight distances on the rest pose."""
    for label, (name, options) in MATCHERS.items():
        start = time.process_time()
        operators = [{} for _ in scans]
        if name == "medial":
            operators = [{"medial": Diffusion.from_points(each.points, each.normals)} for each in scans]
        sides = [MethodInput(str(k), each, operators[k]) for k, each in enumerate(scans)]
        try:
            image = create(name, options).match(*sides, seed).source_to_target
            error = 100 * np.linalg.norm(truth[1][image] - truth[0], axis=1).mean() / np.sqrt(area)
        except InputError as reason:
            sys.stderr.write(f"{label}: {reason}\n")
            error = np.nan
        yield {"method": label, "error": error, "seconds": time.process_time() - start}


def rows_of(name, seed, points, only=None):
    """All rows of a body and a seed, or only those of one table."""
    body = datasets_gen.load(name)
    poses = body.poses[1], body.poses[2 + seed]
    area = body.reference.area
    config = ScannerConfig(views=VIEWS)
    whole = [scanner_sim.scan(body[pose], config, seed=seed) for pose in poses]
    bones = known_bones(body, poses[0])
    for threshold in THRESHOLDS:
        accepted = [each.accept(threshold) for each in whole]
        missing = 1 - scanner_sim.coverage(accepted[0], body[poses[0]])
        scans = [each.subsample(points, seed) for each in accepted]
        truth = [
            body.canonical(body[pose], each.face_ids, each.barycentrics)
            for pose, each in zip(poses, scans, strict=True)
        ]
        about = {"body": name, "seed": seed, "threshold": threshold, "missing_share": missing}
        found = [] if only == "matching" else [*extracted(scans[0], bones, area)]
        found += [] if only == "skeletons" else [*matched(scans, truth, area, seed)]
        for row in found:
            sys.stderr.write(f"{about | row}\n")
            yield about | row


def skeleton_table(rows):
    """Mean over seeds by body, threshold and skeleton, as Markdown."""
    table = rows[rows["skeleton"].notna()]
    groups = table.groupby(["body", "threshold", "skeleton"], sort=False)
    lines = [
        "| body | missing | skeleton | spurious | lacking | loops | parts | right | to bones | from | s |",
        "|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for (body, _, skeleton), group in groups:
        mean = group.mean(numeric_only=True)
        lines.append(
            f"| {body} | {100 * mean['missing_share']:.0f} % | {skeleton} | {mean['spurious']:.1f} "
            f"| {mean['missing']:.1f} | {mean['loops']:.1f} | {mean['parts']:.1f} "
            f"| {int(group['right'].sum())} of {len(group)} | {mean['to_bones']:.1f} "
            f"| {mean['from_bones']:.1f} | {mean['seconds']:.1f} |"
        )
    return "\n".join(lines)


def matching_table(rows):
    """Mean errors over seeds by body and threshold, a column for each method, as Markdown."""
    table = rows[rows["method"].notna()]
    lines = [f"| body | missing | {' | '.join(MATCHERS)} |", "|---|---|" + "---|" * len(MATCHERS)]
    for (body, _), group in table.groupby(["body", "threshold"], sort=False):
        cells = []
        for label in MATCHERS:
            mine = group[group["method"] == label]
            errors = ", ".join("failed" if np.isnan(e) else f"{e:.1f}" for e in mine["error"])
            cells.append(f"{mine['error'].mean():.1f} ({errors}); {mine['seconds'].mean():.0f} s")
        lines.append(f"| {body} | {100 * group['missing_share'].mean():.0f} % | {' | '.join(cells)} |")
    return "\n".join(lines)


def growth(sizes):
    """Processor seconds of each skeleton by the number of points of the complete human."""
    for method in SKELETON_METHODS:
        for n in sizes:
            try:
                found, seconds = timed(skeleton_of, *scanned(n), method)
            except InputError as error:
                sys.stdout.write(f"{error}\n")
                break
            sys.stdout.write(f"{method:<17} {n:>6} points: {seconds:6.1f} s, {found}\n")
            sys.stdout.flush()


def main():
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--bodies", default=",".join(BODIES))
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--points", type=int, default=1200)
    parser.add_argument("--only", choices=("skeletons", "matching"))
    parser.add_argument("--growth", type=int, nargs="+", metavar="POINTS")
    parser.add_argument("-o", "--out", type=Path, metavar="FILE.csv")
    given = parser.parse_args()
    if given.growth:
        growth(given.growth)
        return
    names = given.bodies.split(",")
    seeds = range(given.seeds)
    sets = [rows_of(name, seed, given.points, given.only) for seed in seeds for name in names]
    rows = pd.DataFrame([row for each in sets for row in each])
    if given.out:
        rows.to_csv(given.out, index=False)
    tables = {"skeletons": skeleton_table, "matching": matching_table}
    sys.stdout.write("\n\n".join(tables[name](rows) for name in tables if given.only in (None, name)) + "\n")


if __name__ == "__main__":
    main()
