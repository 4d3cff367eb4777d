"""Execution of runs: from a protocol, from a checkpoint, in sweeps."""
