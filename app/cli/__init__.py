"""Commands of the terminal, one file a group; they parse, call and print."""
