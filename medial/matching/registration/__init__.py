"""Non-rigid registration: deform one cloud onto the other, and judge how well both surfaces meet.

Read in this order:

* `deformation_graph`: nodes, poses, strain; its compiled parts stand in the modules beside it
  (`blending`, `energy_terms`, `normal_equations`, `envelope`, `strongest_paths`),
* `fit`: what a deformed cloud is worth; `visibility`: what either scan could have seen of it,
* `registration`: follow a map, settle by closest points, judge the fit (`rigid_motions`, `closest_points`),
* `direction`: source onto target, or target onto source; a fit knows its direction,
* `exchange`: parts taken from one fit into another; `placement`: how fits of both directions compare,
* `search`: all of these on the fits of a pair,
* `selection`, `refinement`: the best fit, with more nodes, and the dense map that it makes.

All of it decides results: constants were fitted together (their docstrings say on what), and the order of
lists breaks ties.
"""
