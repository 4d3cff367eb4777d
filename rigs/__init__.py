"""The virtual laboratory: protocols, machines, instruments, control of a test, and its record.

It uses ``knitlab_core`` and is used by ``app``.
"""
