"""Open the doors: schemas, the command line and the run folder.

The outer wing, the only one that parses, writes files or talks to people.
"""
