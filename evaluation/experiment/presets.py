"""The packaged experiments."""

from importlib.resources import files


def presets() -> dict[str, str]:
    """Text (TOML) of every packaged experiment, by name."""
    found = [each for each in files("evaluation.protocols").iterdir() if each.name.endswith(".toml")]
    return {
        each.name.removesuffix(".toml"): each.read_text(encoding="utf-8") for each in sorted(found, key=str)
    }
