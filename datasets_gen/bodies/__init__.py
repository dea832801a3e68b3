"""Built-in bodies.

Read in the order in which a body is made: `implicit_surface` (smoothly joined parts), `skeleton`, `skinning`,
`body_plan`, which meshes a plan and poses it, and `proportions` (another seed, another body). `subjects`
makes several bodies with one mesh, `mesh_noise` another mesh of a surface, `built_in` is the table of names.

`human`, `quadruped`, `hand`, `bird` and `octopus` are the plans, each with a module of its poses and of the
limits of its joints. The shapes in `analytic` are formulas.

A new family is a new plan, named in `BODIES` of `built_in`. Any other change changes the bodies, and with
them every published number.
"""
