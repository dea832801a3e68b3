"""Methods, protocols, metrics and sweeps."""
