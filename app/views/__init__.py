"""Views of a run: curves, renders of the knit, SEM images, tables."""
