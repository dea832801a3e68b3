"""The view in a real browser: what it says of a point equals the map that was given."""

import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from reports.viewer.scene import Scene, ViewCloud, ViewField, ViewMap
from reports.viewer.view_page import write_view

BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
FLAGS = (
    *("--headless", "--no-sandbox", "--disable-gpu", "--enable-unsafe-swiftshader", "--no-first-run"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
    *("--virtual-time-budget=8000", "--enable-logging=stderr", "--dump-dom"),
)
N = 400
RNG = np.random.default_rng(0)

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(BROWSER is None, reason="no Chromium here"),
]


def sphere(n):
    points = RNG.normal(size=(n, 3))
    return points / np.linalg.norm(points, axis=1, keepdims=True)


@pytest.fixture(scope="module")
def scene():
    source, target = sphere(N), sphere(300)
    height = ViewField("height", "height", source[:, 1], -1.0, 1.0)
    image = RNG.integers(0, 300, size=N)
    image[7] = -1
    errors = np.round(RNG.random(N) * 9, 2)
    return Scene(
        "a <b>test</b>",
        (
            ViewCloud("source", source, source, colors=(source + 1) / 2, fields=(height,)),
            ViewCloud("target", target, target),
        ),
        (ViewMap("first", image, confidence=RNG.random(N), errors=errors), ViewMap("second", image[::-1])),
        truth=image,
    )


def opened(page: Path, tmp_path: Path, address: str = "", size: str = "1400,900") -> tuple[str, str]:
    """The page as the browser has it after its scripts, and what they complained of."""
    profile = f"--user-data-dir={tmp_path / 'profile'}"
    done = subprocess.run(
        [str(BROWSER), *FLAGS, profile, f"--window-size={size}", f"file://{page}{address}"],
        capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip
    said = (line for line in done.stderr.splitlines() if "CONSOLE" in line)
    complaints = [line for line in said if "GPU stall" not in line]  # of a browser that draws in software
    return done.stdout, "\n".join(complaints)


@pytest.mark.parametrize("size", ["1400,900", "390,800"])
def test_what_is_said_of_a_point_is_its_match(scene, tmp_path, size):
    write_view(scene, tmp_path / "view.html")
    dom, complaints = opened(tmp_path / "view.html", tmp_path, "#colour=error&point=123", size)
    assert complaints == ""
    image, errors, sure = (getattr(scene.maps[0], name)[123] for name in ("image", "errors", "confidence"))
    assert f"first: target point {image}, error {errors:.2f}, confidence {round(255 * sure) / 255:.2f}" in dom
    assert f"second: target point {scene.maps[1].image[123]}" in dom
    assert f"nearest to the true place: target point {scene.truth[123]}" in dom
    assert "10.0 or more" in dom  # the end of the fixed scale of errors
    assert "<b>test</b>" not in dom


def test_a_point_without_a_match_says_so(scene, tmp_path):
    write_view(scene, tmp_path / "view.html")
    dom, complaints = opened(tmp_path / "view.html", tmp_path, "#point=7")
    assert complaints == ""
    assert "first: no match" in dom


def test_landmarks_of_one_map_are_shown_at_a_time(scene, tmp_path):
    maps = [
        replace(each, landmarks=np.array(pairs))
        for each, pairs in zip(scene.maps, ([[1, 2], [3, 4]], [[5, 6], [7, 8], [9, 10]]), strict=True)
    ]
    page = tmp_path / "view.html"
    write_view(replace(scene, maps=tuple(maps)), page)
    script = """<script>
      const points = (panel) => view.marks(panel).map(([point]) => point);
      const marks = () => JSON.stringify(view.panels().map(points));
      const wait = setInterval(() => {
        const select = document.querySelector(".mv-whose");
        if (!window.view || !select) return;
        clearInterval(wait);
        const first = marks();
        select.value = "1"; select.onchange();
        document.body.dataset.said = `${first} ${marks()}`;
      }, 20);
    </script>"""
    page.write_text(page.read_text().replace("</body>", f"{script}</body>"))
    dom, complaints = opened(page, tmp_path)
    assert complaints == ""
    assert 'data-said="[[1,3],[2,4],[]] [[5,7,9],[],[6,8,10]]"' in dom


def test_panels_say_what_is_known_of_a_map_and_from_where_its_target_is_seen(scene, tmp_path):
    behind = RNG.normal(size=(300, 3)) * [1, 1, 0.1]
    target = ViewCloud("target", behind, np.tile([0.0, 0.0, -1.0], (300, 1)), caption="300 points")
    maps = [replace(each, note=f"probability 0.{k}") for k, each in enumerate(scene.maps, start=4)]
    page = tmp_path / "view.html"
    write_view(replace(scene, clouds=(scene.clouds[0], target), maps=tuple(maps)), page)
    script = """<script>
      const wait = setInterval(() => {
        if (!window.view) return;
        clearInterval(wait);
        const words = view.panels().slice(1).map((each) => `${each.title}: ${each.note}`);
        document.body.dataset.said = words.join("; ");
      }, 20);
    </script>"""
    page.write_text(page.read_text().replace("</body>", f"{script}</body>"))
    dom, complaints = opened(page, tmp_path)
    assert complaints == ""
    first, second = (f"{name}, turned by 180°: probability 0." for name in ("first", "second"))
    assert f'data-said="{first}4, 300 points; {second}5, 300 points"' in dom


@pytest.mark.parametrize(
    "address", ["#point=99999&q=a,b&zoom=-3&colour=nothing&tau=x", "#point=&frame=", "#%%%"]
)
def test_a_spoiled_address_is_ignored(scene, tmp_path, address):
    write_view(scene, tmp_path / "view.html")
    dom, complaints = opened(tmp_path / "view.html", tmp_path, address)
    assert complaints == ""
    assert re.search(r'class="mv-readout"[^>]*></div>', dom)
    assert re.search(r'<canvas class="mv-gl"', dom)
