"""Open the doors: schemas, the command line and the run folder.

The outer wing, the only one that parses, writes files or talks to people.
"""

import os

# How a long sum is shared out among threads shows in its last bits, and so in the rows of a run that goes on elsewhere.
os.environ["OPENBLAS_NUM_THREADS"] = "1"
# Plugins of pydantic are none of ours, and looking for them opens the metadata of every installed package.
os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
