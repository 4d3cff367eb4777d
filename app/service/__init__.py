"""Tests as jobs: a durable queue, and a process for each job.

jobs        what a job is, and the interface `JobStore` that API and command line use
settings, address  data folder and database, from the environment; address of the service
tables, deliveries, sweeps, store  `JobStore` in SQL: our tables and DBOS's queue, changed in one transaction
leases      the right of one worker to run and end a job
folder, row_file  a job's folder: spec, progress, rows, figures, log, lock, result
job_process, warm  the process of a job, and what the fork server has loaded before it
supervisor  one delivery of a job: start, watch, stop, record its end
worker, heartbeat  jobs from the queue in N slots; heartbeats, and recovery of jobs of dead workers
housekeeping  deletion of jobs, files and ended deliveries
serving, log, errors  the server process, its log, errors of its clients
api         the REST interface and the console's pages
"""
