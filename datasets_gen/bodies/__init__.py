"""Built-in bodies: implicit surface, skeleton, skinning, proportions; one file per family."""
