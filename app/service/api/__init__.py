"""REST interface of the service: routes, errors, bounds.

build       assembly of the app
context     objects that every route needs: store, token, bounds
guard, connections  access by token or address; limits on connections
bodies, bounds, checking, concurrency  protocols in requests: reading, size limits, checks in threads and in turns
sweeping, sweep_models  jobs from the body of a sweep, and their plan; answers about sweeps
head_requests, etags, transfer, pages  HEAD, entity tags, file downloads, pages of the console
problems, faults  errors in the form of RFC 9457; faults of disk and database
models, documents  content of the OpenAPI document
routes      one module a part of the REST table
rows, streams  rows of a running test, and their stream to a client
row_curves, growing_record  curves from the rows of a test; reading of a record that may be written
compared    a measured file over the test of a job
metrics     Prometheus metrics
"""
