"""What a user says: specimen, rig, steps with their targets, log."""
