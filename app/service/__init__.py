"""Tests as jobs: a durable queue, and a process for each job.

jobs        what a job is, and the seam `JobStore` that the doors talk to
settings, address  where the data and the database are, from the environment; where the service is
tables, deliveries, store  the seam in SQL: our tables, DBOS's queue, both in one transaction
folder      a job's folder: spec, progress, rows, log, lock, result
child, warm what runs in the process of a job, and what that process has ready
supervisor  one delivery of a job: start, watch, stop, settle
worker, pulse  take jobs from the queue in N slots; heartbeats, and jobs of dead workers
"""
