"""An undisturbed table to compare with, and the count of faults."""

from collections import Counter

import pytest

from tests.faults.sweep import content, experiment, run_here

PROPERTY = "faults injected"


@pytest.fixture
def injected(record_property):
    """Notes faults of a kind: one for each moment at which a sweep is disturbed; printed at the end."""

    def note(kind, count=1):
        record_property(PROPERTY, (kind, count))

    return note


def pytest_terminal_summary(terminalreporter):
    """How many faults were injected, by kind."""
    found = Counter()
    for report in terminalreporter.stats.get("passed", []) + terminalreporter.stats.get("failed", []):
        for name, value in report.user_properties if report.when == "call" else ():
            if name == PROPERTY:
                found[value[0]] += value[1]
    if found:
        shown = ", ".join(f"{kind} {count}" for kind, count in sorted(found.items()))
        terminalreporter.write_line(f"{found.total()} faults injected: {shown}")


@pytest.fixture(scope="session")
def settings(tmp_path_factory):
    """The experiment, and a file that holds it."""
    folder = tmp_path_factory.mktemp("experiment")
    made = experiment(folder)
    (folder / "small.toml").write_text(made.to_toml())
    return made, folder / "small.toml"


@pytest.fixture(scope="session")
def undisturbed(settings, tmp_path_factory):
    """The table of a sweep that nothing has disturbed."""
    folder = tmp_path_factory.mktemp("undisturbed") / "results"
    with pytest.MonkeyPatch.context() as patch:
        run_here(settings[0], folder, patch)
    return content(folder)
