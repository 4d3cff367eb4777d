"""Figures of a test from its curves."""
