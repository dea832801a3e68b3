"""Experiments: settings from TOML, the plan of tasks."""
