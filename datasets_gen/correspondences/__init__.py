"""Files of correspondences, as programs of this field write them.

Read `point_map` (what a file says), then `reading` and `writing`. Every format states in one place from where
it counts and in which direction it maps: that is what is most often got wrong.
"""
