"""Running a plan on a Dask cluster."""
