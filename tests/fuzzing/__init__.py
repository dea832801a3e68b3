"""Every reader with broken files: a valid object or an `InputError`, soon, and nothing written elsewhere.

`targets` lists the readers, `seeds` makes sound files, `mutations` and `arrays` break them, `judge` says what
is wrong with an outcome, `fuzz` is the long run (``make fuzz``). ``corpus/<target>/`` holds files that once
failed.
"""
