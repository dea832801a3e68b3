"""Settings of the matcher that take a third of the time: most tests ask what goes in and out of a match."""

from medial import MatchConfig

LITTLE = {"finalists": 2, "restarts": 4, "partners": 2, "nodes": 40, "fine_nodes": 80, "samples": 200}
LITTLE |= {"recombine": False, "both_ways": False, "rigid_starts": False}
CHEAP = MatchConfig(**LITTLE)
AS_OPTIONS = [word for name, value in LITTLE.items() for word in ("--set", f"{name}={str(value).lower()}")]
