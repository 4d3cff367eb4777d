"""Open the doors: schemas, the command line and the run folder.

The outer wing, the only one that parses, writes files or talks to people.
"""

import os

# How a long sum is shared out among threads shows in its last bits, and so in the rows of a run that goes on elsewhere.
os.environ["OPENBLAS_NUM_THREADS"] = "1"
