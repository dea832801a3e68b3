"""What is written of a scan.

`ply` (points with attributes), `range_images`, and `contact_sheet` (the rig, one view, and what became of its
pixels). None of them changes a scan.
"""
