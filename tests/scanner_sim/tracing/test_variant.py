"""Probing of variants, and agreement between them."""

import subprocess
import sys

import numpy as np
import pytest

from datasets_gen import InputError
from scanner_sim import ScannerConfig, scan, variant_report
from scanner_sim.tracing import variant
from tests.scanner_sim.conftest import usable


@pytest.fixture
def fresh(monkeypatch, tmp_path):
    """No memory of earlier probes, in this process or on disk."""
    monkeypatch.setenv("MEDIALBENCH_CACHE", str(tmp_path))
    for name in ("MEDIALBENCH_VARIANT", "DRJIT_LIBLLVM_PATH"):
        monkeypatch.setenv(name, "")  # so that the value, or its absence, is put back
        monkeypatch.delenv(name)
    remembered = (variant.probe, variant.choose)
    for function in remembered:
        function.cache_clear()
    yield monkeypatch
    for function in remembered:
        function.cache_clear()


def test_without_llvm_the_scalar_variant_is_chosen(fresh):
    fresh.setenv("DRJIT_LIBLLVM_PATH", "/nonexistent")
    fresh.setattr(variant, "_has_nvidia", lambda: False)
    assert variant.choose() == "scalar_rgb"
    outcome = variant.probe(variant.LLVM)[-1]
    assert not outcome.works
    assert "no file" in outcome.reason


def test_a_library_that_is_none_is_survived(fresh, tmp_path):
    bad = tmp_path / "libLLVM.so"
    bad.write_bytes(b"not a library")
    fresh.setenv("DRJIT_LIBLLVM_PATH", str(bad))
    outcome = variant.probe(variant.LLVM)[-1]
    assert not outcome.works
    assert outcome.reason
    assert "\n" not in outcome.reason


def test_a_child_that_aborts_or_hangs_is_a_failed_probe(fresh):
    fresh.setattr(sys, "executable", "/bin/false")
    assert not variant._run(variant.LLVM, None).works
    assert "signal 6" in variant._reason(-6, "LLVM ERROR: Cannot select\n")
    fresh.undo()
    fresh.setattr(variant, "TIMEOUT", 0.001)
    assert "longer" in variant._run(variant.SCALAR, None).reason


def test_a_passed_probe_is_remembered_on_disk_and_a_failed_one_is_not(fresh):
    runs = []

    def run(name, library):
        runs.append(name)
        return variant.Probe(name, len(runs) > 1, "" if len(runs) > 1 else "unlucky", library)

    fresh.setattr(variant, "_run", run)
    outcomes = [variant._probed(variant.CUDA, None).works for _ in range(3)]
    assert outcomes == [False, True, True]
    assert len(runs) == 2


@pytest.mark.parametrize(
    "content", ["[]", "{", '{"variant": "cuda_ad_rgb"}', '{"works": "no"}', "[" * 100_000]
)
def test_a_damaged_note_of_a_probe_is_made_again(fresh, content):
    fresh.setattr(variant, "_run", lambda name, library: variant.Probe(name, True, "", library))
    path = variant._cache_file(variant.CUDA, None)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(content)
    assert variant._probed(variant.CUDA, None) == variant.Probe(variant.CUDA, True, "")
    fresh.setattr(variant, "_run", None)
    assert variant._probed(variant.CUDA, None).works


def test_override_wins_and_unusable_overrides_are_errors(fresh):
    fresh.setenv("MEDIALBENCH_VARIANT", "scalar_rgb")
    assert variant.choose() == "scalar_rgb"
    variant.choose.cache_clear()
    fresh.setenv("MEDIALBENCH_VARIANT", "scalar_rbg")
    with pytest.raises(InputError, match="scalar_rbg"):
        variant.choose()
    fresh.setenv("MEDIALBENCH_VARIANT", variant.LLVM)
    fresh.setenv("DRJIT_LIBLLVM_PATH", "/nonexistent")
    with pytest.raises(InputError, match="no file"):
        variant.choose()


def test_preference_is_cuda_then_llvm(fresh):
    fresh.setattr(variant, "probe", lambda name: (variant.Probe(name, name != variant.SCALAR, ""),))
    assert variant.choose() == variant.CUDA


def test_report_names_every_variant_and_never_raises(fresh):
    fresh.setenv("MEDIALBENCH_VARIANT", "nonsense")
    fresh.setenv("DRJIT_LIBLLVM_PATH", "/nonexistent")
    report = variant_report()
    assert report["chosen"] is None
    assert "nonsense" in report["error"]
    assert {probe.variant for probe in report["probes"]} == set(variant.PREFERENCE)
    assert all(probe.works or probe.reason for probe in report["probes"])


def test_libraries_are_real_files_newest_first_and_each_once(fresh, tmp_path):
    newer, older = tmp_path / "new", tmp_path / "old"
    for folder, names in ((older, ["libLLVM-9.so", "libLLVMCore.so.20"]), (newer, ["libLLVM.so.19.1"])):
        folder.mkdir()
        for name in names:
            (folder / name).write_text("")
    (newer / "libLLVM.so").symlink_to("libLLVM.so.19.1")
    fresh.setattr(variant, "_FOLDERS", (str(older), str(newer), "/nonexistent"))
    fresh.delenv("CONDA_PREFIX", raising=False)
    found = [newer / "libLLVM.so.19.1", older / "libLLVM-9.so"]
    assert variant.llvm_libraries() == [str(path.resolve()) for path in found]
    (tmp_path / "lib").mkdir()
    (tmp_path / "lib" / "libLLVM.20.dylib").write_text("")
    fresh.setenv("CONDA_PREFIX", str(tmp_path))
    assert variant.llvm_libraries()[0] == str((tmp_path / "lib" / "libLLVM.20.dylib").resolve())


def test_a_callers_own_variant_is_put_back_and_ours_is_left():
    """Each in a process of its own: it is about what was set first."""
    for first, last in (("", "scalar_rgb"), ("mi.set_variant('scalar_spectral');", "scalar_spectral")):
        code = (
            f"import mitsuba as mi; {first}"
            "from scanner_sim.tracing import variant\n"
            "with variant.active('scalar_rgb') as inside: assert inside.variant() == 'scalar_rgb'\n"
            f"assert mi.variant() == {last!r}, mi.variant()"
        )
        subprocess.run([sys.executable, "-c", code], check=True)


def test_importing_the_scanner_does_not_load_mitsuba():
    code = "import sys, scanner_sim; assert 'mitsuba' not in sys.modules and 'drjit' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_scalar_and_llvm_agree(torus, monkeypatch):
    found = []
    for name in (variant.SCALAR, usable(variant.LLVM)):
        monkeypatch.setattr(variant, "choose", lambda name=name: name)
        found.append(scan(torus, ScannerConfig(views=4, resolution=(150, 150), noise=0.0), seed=1))
    first, second = found
    assert np.array_equal(first.view_ids, second.view_ids)
    assert np.array_equal(first.pixels, second.pixels)
    assert (first.face_ids == second.face_ids).mean() > 0.998
    gap = np.linalg.norm(first.points - second.points, axis=1)
    assert (gap > 1e-6).mean() < 5e-4
    assert np.abs(first.intensity - second.intensity).max() < 3 / 255
    first, second = (each.accept(0.8).subsample(900, seed=2) for each in found)
    assert np.array_equal(first.pixels, second.pixels)
