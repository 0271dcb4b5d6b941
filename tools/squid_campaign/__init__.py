"""Campaigns of `squid campaign` on the workers of a Dask cluster.

__main__   the command `python -m squid_campaign`, which sends missing parts to the workers
ways       by the command `squid` or by FMUs: files for a worker, and processing of its results
worker     the code that runs on a worker
"""
