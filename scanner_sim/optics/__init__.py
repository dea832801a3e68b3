"""The scanner's physics without Mitsuba: from the rays that hit the object to measured points.

In the order of the light: `viewpoints` and `camera` (where the eyes stand, which ray belongs to a pixel),
`hits` (what tracing hands over), `stripe` (how much of each laser stripe falls on a point), `translucency`
(light from below the surface), `contributions` (which points light a pixel), `rows` (its samples over time),
`blur`, `sensor` with `noise` and `speckle`, `peak` with the folder ``detectors``, `triangulation` with
`calibration`, `verdict` (what became of a pixel, and why), and `measurement`, which puts them together.

Every formula decides results: scans change to the last bit with it.
"""
