"""Report of runs: one self-contained HTML page, and the same as PDF.

drawings  plots of the app as inline SVG, pictures as data
assumed   what a run rests on: defaults, assumed numbers, the mesh and its error
figures   results of several runs in one table
contents  all that the page says of one run
page      the template filled in, and the files
"""
