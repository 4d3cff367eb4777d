"""Command line, service, schemas, run folders and views: what users and files meet.

The outer wing, the only one that parses, writes files or talks to users.
"""

import os

# The number of BLAS threads changes the last bits of sums, and so the rows of a run resumed on another machine.
os.environ["OPENBLAS_NUM_THREADS"] = "1"
# Plugins of pydantic are none of ours, and looking for them opens the metadata of every installed package.
os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
