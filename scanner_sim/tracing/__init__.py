"""Rays with Mitsuba.

Start with `tracer`: what the camera of a view sees. It uses `rig_frame` (where the mesh stands),
`mitsuba_mesh` (Mitsuba's copy of it), `scenes` (rendered or asked ray by ray), `materials`, `albedo` (the
mesh's own colours), `surface_points` (exact hits and normals) and `background` (a plane behind the object).
`variant` finds a sound Mitsuba variant with the help of `probe`, in child processes. `brute_force` renders
every stripe: slow, for validation and for light that bounces.

`variant` and `probe` may be changed without harm to results; the rest decides them.
"""
