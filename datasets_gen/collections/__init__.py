"""Collections from files: one module per source."""
