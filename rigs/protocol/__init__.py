"""Protocol of a test: specimen, rig, steps with their targets, log."""
