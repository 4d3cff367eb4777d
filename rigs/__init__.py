"""Put the laboratory together: protocols, fixtures, instruments, the run and its record.

The middle wing. It stands on ``knitlab_core`` and is used by ``app``.
"""
