"""The results folder: what is stored, the table merged from it, and folders joined.

Read `store` (the folder and its files), `outcome` (how a task ended), `table` (the columns and how rows
are filled), `origin` (what made it, in every file of it), then `merging` (several folders into one) and
`folder_lock`. `store.FORMAT` numbers the
layout of files: raise it when they change.
"""
