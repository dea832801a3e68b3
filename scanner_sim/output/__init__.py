"""What is written of a scan.

Points: `ply` and, with further `packages`, `las` and `e57`; `frame_note` is what they say of frame and units.
`range_images` with cameras. `truth`: the complete surface and what the scan has of it. `contact_sheet`, with
`sheet_view`, `sheet_panels` and `pixel_profiles`: the rig, every view, what became of its pixels, and what
each threshold drops. None of them changes a scan.
"""
