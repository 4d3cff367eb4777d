"""A run on the disk: layout, writer, reader, checkpoint, lock, checks against damage, export."""
