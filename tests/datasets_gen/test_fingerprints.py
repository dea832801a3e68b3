import hashlib
import sys

import numpy as np
import pytest

from datasets_gen import fingerprints
from datasets_gen.fingerprints import canonical, code_fingerprint, digest, library_versions, seed_of

CACHED = ("_fingerprint", "_module_facts", "_parsed", "_home", "_is_package")


@pytest.fixture
def package(tmp_path, monkeypatch):
    """A project package `lib` with two modules, of which `front` uses `back`; call to write it anew."""
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(fingerprints, "PROJECT", ("lib",))
    caches = [getattr(fingerprints, name) for name in CACHED]

    def write(front="from lib.back import f\n", back="def f():\n    return 1\n", init="", other="x = 1\n"):
        folder = tmp_path / "lib"
        folder.mkdir(exist_ok=True)
        texts = {"__init__": init, "front": front, "back": back, "other": other}
        for name, text in texts.items():
            (folder / f"{name}.py").write_text(text)
        for cache in caches:
            cache.cache_clear()
        return code_fingerprint("lib.front")

    yield write
    for cache in caches:
        cache.cache_clear()
    for name in [name for name in sys.modules if name.split(".")[0] == "lib"]:
        del sys.modules[name]


def test_code_that_matters(package):
    before = package()
    assert package() == before
    assert package(back="def f():\n    return 2\n") != before
    assert package(front="from lib.back import f\ny = 1\n") != before


def test_code_that_does_not_matter(package):
    before = package()
    assert package(other="x = 2\n") == before
    assert package(back='def f():\n    """Say so."""\n    # really\n    return   1\n') == before


def test_imports_through_a_package_and_inside_functions_count(package):
    init = "from lib.back import f\nfrom lib.other import x\n"
    front = "def g():\n    from lib import f\n    return f\n"
    before = package(front=front, init=init)
    assert package(front=front, init=init, back="def f():\n    return 2\n") != before
    assert package(front=front, init=init, other="x = 2\n") == before


def test_versions_of_imported_libraries_count(package, monkeypatch):
    use = "import numpy\nfrom lib.back import f\n"
    before = package(front=use)
    assert library_versions("lib.front") == {"numpy": np.__version__}
    monkeypatch.setattr(fingerprints, "version", lambda name: "0.0")
    assert package(front=use) != before
    assert package() == package(other="import numpy\n")  # another module's libraries do not count


def test_libraries_that_decide_nothing_or_are_missing_do_not_count(package):
    before = library_versions("lib.front") if package() else None
    package(front="import rich\nimport no_such_library\nfrom lib.back import f\n")
    assert library_versions("lib.front") == before == {}


def test_a_library_that_a_project_module_imports_counts(package):
    package(back="from scipy.spatial import cKDTree\nfrom skimage import measure\ndef f():\n    return 1\n")
    assert list(library_versions("lib.front")) == ["scikit-image", "scipy"]


def test_a_file_is_read_again_after_a_change(tmp_path):
    file = tmp_path / "mine.py"
    file.write_text("x = 1\n")
    before = code_fingerprint(str(file))
    file.write_text("# one\nx = 1\n")
    assert code_fingerprint(str(file)) == before
    file.write_text("x = 2\n")
    assert code_fingerprint(str(file)) != before


def test_stages_are_keyed_by_the_libraries_they_compute_with():
    render = library_versions("evaluation.running.stages.render_views")
    assert {"numpy", "scipy", "mitsuba", "drjit"} <= set(render)
    reached = fingerprints._reached(["evaluation.running.stages.render_views"])
    assert "scanner_sim.scanner" in reached  # `scanner_sim.scan` is a function there, and a module as well
    assert {"numpy", "scipy", "numba"} <= set(library_versions("evaluation.running.stages.build_operator"))
    assert {"numpy", "scikit-image"} <= set(library_versions("datasets_gen.bodies.human"))


def test_a_metric_reaches_scores_and_not_scans():
    scan = fingerprints._imported(fingerprints._parsed("evaluation.running.stages.threshold_scan"))
    assert not any("metrics" in name for name in scan)
    assert "evaluation.metrics.correspondence" in set(
        fingerprints._imported(fingerprints._parsed("evaluation.running.stages.score"))
    )


def test_one_text_for_one_value():
    assert canonical({"b": 1.0, "a": (1, 2)}) == canonical({"a": [1, 2], "b": 1}) == '{"a":[1,2],"b":1}'
    assert digest({"a": 0.1}) == hashlib.sha256(b'{"a":0.1}').hexdigest()


@pytest.mark.parametrize(
    ("parts", "text"),
    [(("render", "human", 0), '["render","human",0]'), (("render", "human", 1), '["render","human",1]')],
)
def test_seeds_are_the_first_31_bits_of_a_hash_of_the_identity(parts, text):
    """Results of earlier versions stay those of their seeds only if the number stays."""
    assert seed_of(*parts) == int(hashlib.sha256(text.encode()).hexdigest()[:8], 16) // 2
