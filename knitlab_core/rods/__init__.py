"""Discrete elastic rods: frames, rest shapes, energies and their derivatives."""
