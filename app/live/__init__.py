"""A rig that is driven step by step, from Python or over a socket, and recorded as a protocol with these steps."""
