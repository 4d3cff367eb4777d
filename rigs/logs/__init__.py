"""Write logs as instruments do: one file a dialect, and one writer for all of them."""
