"""Built-in bodies.

Read in the order in which a body is made: `implicit_surface` (smoothly joined parts), `proportions`
(another seed, another body), `skeleton`, `skinning`, and `body_plan`, which meshes a plan and poses it.
`human` and `quadruped` are the plans, with their poses in `human_poses` and `quadruped_poses`.

A new family is a new plan, named in `datasets_gen.registry`. Any other change changes the bodies, and with
them every published number.
"""
