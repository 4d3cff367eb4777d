"""Answer requests: one module a part of the REST table."""
