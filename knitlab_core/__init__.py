"""Compute the mechanics of knits: rods, contact, friction, equilibrium.

The inner wing. It imports numpy, scipy and numba; it opens no file and parses no text.
"""
