"""Figures, tables and the report page; reads only the results store."""
