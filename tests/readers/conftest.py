# Programs of another environment: `make readers`.
collect_ignore_glob = ["read_*.py"]
