"""Time flights of `squid campaign` against FMPy, which steps the FMUs of plant and controller, in one run.

Run `python3 run.py fly` first. Writes a table to docs/benchmarks.md.
"""

from __future__ import annotations

import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time

from page import ROOT, in_environment, put

VEHICLE = ROOT / "vehicles" / "squid"
FOLDER = ROOT / "build" / "squid" / "design"
FLIGHTS, ROUNDS = 256, 5


def campaign(threads: int, flights: int = FLIGHTS) -> tuple[float, float, float]:
    """Return wall-clock and processor time per flight (s), and the peak memory of the process (MB)."""
    from fly import build

    with tempfile.TemporaryDirectory() as to:
        words = [build.squid(), "campaign", VEHICLE, "--out", FOLDER, "--no-bound", "--to", to]
        words += ["--flights", str(flights)]
        known, began = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
        variables = os.environ | {"RAYON_NUM_THREADS": str(threads)}
        subprocess.run(words, check=True, capture_output=True, env=variables)
        wall, now = time.perf_counter() - began, resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = now.ru_utime + now.ru_stime - known.ru_utime - known.ru_stime
    return wall / flights, cpu / flights, now.ru_maxrss / 1e3


def fmpy() -> tuple[float, float]:
    """Return wall-clock and processor time (s) of the default simulation, without reading and unpacking the FMUs."""
    from fly import flight, record
    from fly.master import Slave, couple
    from fly.package import Packages

    packages = Packages.found_in(FOLDER)
    loop = record.read(FOLDER / "flight.csv")
    end, sample_time = float(loop["time"][-1]), flight.sample_time_of(packages)
    with Slave(packages.plant, "plant") as plant, Slave(packages.controller, "controller") as controller:
        plant.begin({"initial_speed": float(loop["path_speed"][0])})
        controller.begin()
        wall, cpu = time.perf_counter(), time.process_time()
        couple(plant, controller, record.references_in(loop), end, sample_time)
        return time.perf_counter() - wall, time.process_time() - cpu


def rows() -> list[str]:
    """Measure in turn, and return the table."""
    rounds = [(campaign(1), campaign(2), fmpy()) for _ in range(ROUNDS)]
    one, two, peer = (
        [statistics.median(column) for column in zip(*runs, strict=True)]
        for runs in zip(*rounds, strict=True)
    )
    many = campaign(2, 10 * FLIGHTS)
    measured = {
        f"`squid campaign`, one core, {FLIGHTS} flights": one,
        f"two cores, {FLIGHTS} flights": two,
        f"two cores, {10 * FLIGHTS} flights": many,
        "FMPy, one core": peer,
    }
    lines = ["| | ms a flight | of processor time | flights a second |", "|---|---|---|---|"]
    for what, (wall, cpu, *_) in measured.items():
        lines.append(f"| {what} | {1e3 * wall:.1f} | {1e3 * cpu:.1f} | {1.0 / wall:.3g} |")
    return [
        *lines,
        "",
        f"One core flies {peer[0] / one[0]:.1f} times as many as with FMPy; two fly {one[0] / many[0]:.2f} times as "
        f"many as one, {one[0] / two[0]:.2f} times where there are few, the start of the process included.",
        f"The memory is at most {one[2]:.0f} MB with {FLIGHTS} flights, {many[2]:.0f} MB with {10 * FLIGHTS}.",
    ]


def main() -> int:
    """Measure, and write the table."""
    in_environment(__file__)
    put("campaign", rows())
    return 0


if __name__ == "__main__":
    sys.exit(main())
