"""Where the rig stands and how it moves.

`stations`: poses of the cameras. `passes`: how the rig travels past the object. `profiler`, with
`line_image`: the line profiler, which measures one profile per frame of a pass.
"""
