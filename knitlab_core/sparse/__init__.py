"""Sparse symmetric systems of 4 x 4 blocks: ordering, Cholesky factorisation, GMRES."""
