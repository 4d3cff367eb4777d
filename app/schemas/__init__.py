"""Reading and writing of protocols: the only place that parses what a user wrote.

loading, swept  from any source to the domain's protocol, and to one for every point of a sweep
document  YAML to plain data with lines and columns
params, sweep  `${param}` replaced by its value; the points of a sweep
values    quantities and other single values
defaults  defaults of fields that a file leaves out
base, models, specimen, material_models, materials  structure, published as JSON Schema
locate    errors with file, line and column
here      which words a protocol's rig and knit allow
further   what is out of range in the parts of a protocol whose form is right
step_parts, steps  steps: for each its model and its conversion
convert, convert_steps, convert_specimen, convert_substance  models to the domain's protocol, and back to text
yarns     a yarn by measurement, in a protocol and in a file of materials
tables    points of waveforms and rows of yarn between plates, from CSV files beside a protocol
centrelines  a yarn of the user's own, as CSV
material_files  files of materials of one's own
files_beside, named_files  files that a protocol names, on a disk or sent with it; the materials and centreline in them
field_titles  what each field is, for the published schema
"""

from app.schemas.convert import to_data, to_yaml
from app.schemas.errors import ProtocolError
from app.schemas.loading import Loaded, Source, from_yaml, json_schema, load, loads, loads_document
from app.schemas.swept import load_sweep

__all__ = [
    "Loaded",
    "ProtocolError",
    "Source",
    "from_yaml",
    "json_schema",
    "load",
    "load_sweep",
    "loads",
    "loads_document",
    "to_data",
    "to_yaml",
]
