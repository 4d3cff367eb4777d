"""Routes: one module a part of the REST table."""
