"""Studies: questions that many runs answer together, each with its designs, its table and its figure."""
