"""What people look at: curves, renders of the knit, SEM images, tables."""
