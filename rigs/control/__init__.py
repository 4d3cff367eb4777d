"""Carrying a test out: strokes, setpoints, control of displacement and force, stop criteria, resume point."""
