"""REST interface of the service: routes, errors, bounds.

build       the app, put together
context     what every route needs: the store, the token, the bounds
guard       who is let in
bodies, bounds  read protocols, and refuse what is too large before it is
heads, tags, transfer, pages  HEAD, what a client has already, files and their ranges, the pages of a browser
problems    errors as RFC 9457 has them
models, documents  what the OpenAPI document says
routes      one module a part of the table
rows, streams  what a running test has found so far, and its stream to a client
metrics     figures for Prometheus
"""
