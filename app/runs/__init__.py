"""Carrying runs out: from a protocol, from a checkpoint, in sweeps."""
