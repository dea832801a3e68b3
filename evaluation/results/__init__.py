"""The results folder: store, table, merging."""
