"""What can be said of a protocol before it runs: specimen, plan, budgets, size of the log."""
