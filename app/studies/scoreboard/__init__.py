"""The scoreboard: the claims of the paper beside what the lab's own tests say.

plan      the tests, full and quick
runs      each test in a folder of its own, kept and used again
analysed  what a row is scored by, from a record
planar, designs, volumetric, constants  scores of the rows, one function each
verdict   criteria, in numbers and in words
rows      the table of claims
board     all of it: run, score
report    the table as data and as Markdown, and what the page of figures needs
"""
