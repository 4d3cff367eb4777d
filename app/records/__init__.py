"""Files of a run on disk: layout, writer, reader, checkpoint, lock, integrity checks, export."""
