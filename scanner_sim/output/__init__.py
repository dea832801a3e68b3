"""What is written of a scan: exports and previews."""
