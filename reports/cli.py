"""Command line `medialbench`: the one place that sees all packages."""


def main() -> None:
    """Entry point."""
