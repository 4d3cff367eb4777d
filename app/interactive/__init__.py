"""Tests from Python and notebooks: what `knitlab.run` gives, and how it shows itself.

running   runs and resumes tests, with a progress bar where somebody looks
results   a run with its tables, plots and pictures
scene     the knit as a picture that can be turned
"""
