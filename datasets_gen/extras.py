"""How to install the packages of an extra, for messages about those that are missing."""

from importlib.metadata import PackageNotFoundError, distribution

from datasets_gen.parsing import parsed_json
from datasets_gen.records import InputError

PROJECT = "medialbench"


def pip_install(extra: str) -> str:
    """The command that installs an extra: of the checkout where the code is used from one, else by name.

    Parameters
    ----------
    extra
        Of ``pyproject.toml``, as ``"peers"``.
    """
    return f"pip install -e '.[{extra}]'" if is_checkout() else f"pip install '{PROJECT}[{extra}]'"


def is_checkout() -> bool:
    """Whether the code is an editable installation, or not installed at all (PEP 610)."""
    try:
        origin = distribution(PROJECT).read_text("direct_url.json")
    except PackageNotFoundError:
        return True
    try:
        return bool(parsed_json(origin or "{}", "direct_url.json").get("dir_info", {}).get("editable", False))
    except (InputError, AttributeError):
        return False
