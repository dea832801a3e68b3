"""Which places of a module are mutated."""

from tests.mutation.sites import lies_in, passed_over

SOURCE = """
CUT = 2.5
HALF = CUT / 2


@decorated(3)
def f(x: int | None, *, y: float = 7, z: int | None = 5 * 2) -> float | None:
    if x < 4:
        raise ValueError(5 * "x")
    return g(*x, **y) + 6


class A:
    width: int | float = 8
    length: float = 9 * 1
"""


def mutated(text):
    """Whether the first place of a text would be mutated."""
    lines = SOURCE.splitlines()
    line = next(k for k, each in enumerate(lines) if text in each)
    return not lies_in((line + 1, lines[line].index(text)), passed_over(SOURCE))


def test_formulas_are_mutated():
    assert all(map(mutated, ("CUT / 2", "/ 2", "7", "5 * 2", "* 2", "< 4", "+ 6", "9 *", "* 1")))


def test_settings_annotations_decorators_and_what_is_raised_are_not():
    assert not any(
        map(
            mutated,
            ("2.5", "3)", "| None, *", "*, y", "| None =", "| None:", '5 * "x', "*x", "**y", "| float", "8"),
        )
    )
