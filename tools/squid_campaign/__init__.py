"""Campaigns of `squid campaign` on the workers of a Dask cluster.

__main__   the command `python -m squid_campaign`: what is missing goes to the workers
ways       by the command `squid` or by FMUs: what a worker needs, and what becomes of what it sends
worker     what runs on a worker
"""
