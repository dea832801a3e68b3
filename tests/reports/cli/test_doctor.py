"""What works here, and that a broken scanner does not end it."""

from tests.reports.cli.command_line import run


def test_doctor_names_variants_and_methods():
    result = run("doctor", "-q")
    assert result.exit_code == 0, result.output
    variants, devices = ("scalar_rgb", "llvm_ad_rgb", "cuda_ad_rgb"), ("device cpu", "device cuda")
    for word in (*variants, *devices, "medial", "heat", "mitsuba", "Python"):
        assert word.lower() in result.output.lower()


def test_doctor_survives_a_broken_scanner(monkeypatch):
    from scanner_sim.tracing import variant

    def broken():
        raise OSError("no Mitsuba")

    monkeypatch.setattr(variant, "variant_report", broken)
    result = run("doctor", "-q")
    assert result.exit_code == 1
    assert "Traceback" not in result.output
    assert "no Mitsuba" in result.stderr
    assert "medial" in result.stdout
