"""Tests from Python and notebooks: what `knitlab.run` and others give, and how it shows itself.

running   runs and resumes tests, with a progress bar where somebody looks
sweeps, comparisons, calibrations  the same for many tests
results   a run with its tables, plots and pictures
scene     the knit as a picture that can be turned
markup    parts of the pages that a notebook shows
"""
