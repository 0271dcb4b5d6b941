"""Time a step of the depth and heading controllers in one FMU through the C ABI, relative to depth alone.

Run `python3 run.py fly` first, which builds the command and the binaries. Writes a line to docs/benchmarks.md.
"""

from __future__ import annotations

import os
import statistics
import sys
import tempfile
from pathlib import Path

from abi_peers import COUNT, HERE, TURNS, compiled_driver, from_fmu
from page import ROOT, in_environment, put, squid

VEHICLE = ROOT / "vehicles" / "lauv"
STEP = 0.02
ONE, BOTH = ("propeller", "stern_planes"), ("propeller", "stern_planes", "rudder")


def main() -> int:
    """Measure, and write the line."""
    in_environment(__file__, "abi", HERE / "requirements.txt")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        os.chdir(folder)
        squid("design", VEHICLE)
        made = folder / "build" / VEHICLE.name / "design"
        found = []
        for title, outputs, more, there in (("one", ONE, ["--axis", "depth"], "depth"), ("both", BOTH, [], "")):
            squid("package", VEHICLE, *more)
            fmu = made / there / f"{VEHICLE.name}_controller.fmu"
            found.append(from_fmu(title, fmu, folder / title, list(outputs), COUNT))
        driver = compiled_driver(folder)
        turns = [[peer.measure(driver, STEP, peer.count, 5)[0] for peer in found] for _ in range(TURNS)]
        one, both = (statistics.median(turn[i] for turn in turns) for i in (0, 1))
        ratio = statistics.median(turn[1] / turn[0] for turn in turns)
        os.chdir(ROOT)
    words = f"LAUV: depth {one:.0f} ns a step; depth and heading in one FMU {both:.0f} ns, {ratio:.2f} times that."
    put("abi axes", [words])
    return 0


if __name__ == "__main__":
    sys.exit(main())
