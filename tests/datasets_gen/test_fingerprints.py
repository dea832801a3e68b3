import sys

import pytest

from datasets_gen import fingerprints as identity
from datasets_gen.fingerprints import canonical, code_version, digest, seed_of


@pytest.fixture
def package(tmp_path, monkeypatch):
    """A project package `lib` with two modules, of which `front` uses `back`; call to write it anew."""
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(identity, "PROJECT", ("lib",))
    caches = (code_version, identity._facts, identity._parsed, identity._home, identity._is_package)

    def write(front="from lib.back import f\n", back="def f():\n    return 1\n", init="", other="x = 1\n"):
        folder = tmp_path / "lib"
        folder.mkdir(exist_ok=True)
        texts = {"__init__": init, "front": front, "back": back, "other": other}
        for name, text in texts.items():
            (folder / f"{name}.py").write_text(text)
        for cache in caches:
            cache.cache_clear()
        return code_version("lib.front")

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


def test_a_metric_reaches_scores_and_not_scans():
    scan = identity._imported(identity._parsed("evaluation.running.stages.threshold_scan"))
    assert not any("metrics" in name for name in scan)
    assert "evaluation.metrics.correspondence" in set(
        identity._imported(identity._parsed("evaluation.running.stages.score"))
    )


def test_one_text_for_one_value():
    assert canonical({"b": 1.0, "a": (1, 2)}) == canonical({"a": [1, 2], "b": 1})
    assert digest({"a": 0.1}) != digest({"a": 0.2})


def test_seeds_come_from_identities():
    assert seed_of("render", "human", 0) == seed_of("render", "human", 0)
    assert seed_of("render", "human", 0) != seed_of("render", "human", 1)
    assert 0 <= seed_of("x") < 2**31
