"""Camera, viewpoints, laser stripe, sensor, peak fit and triangulation."""
