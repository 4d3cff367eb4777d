"""Contact and friction between strands, as a line potential over smooth centrelines."""
