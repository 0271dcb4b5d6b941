"""The generated files that are committed: frozen designs of the vehicles, and the model descriptions of Squid's FMUs.

They show a reader what comes out without a build, and a change of any of them in review. A test keeps them fresh.
"""

from __future__ import annotations

from pathlib import Path

from fly import build
from fly.stages import ROOT, run, stage

VEHICLES = ("squid", "remus100")
DESCRIBED = "squid"
DESCRIPTIONS = ROOT / "modelDescription"


def frozen(vehicle: str) -> Path:
    """Return the directory of a vehicle's frozen design."""
    return ROOT / "vehicles" / vehicle / "frozen"


def freeze() -> int:
    """Make all generated files anew."""
    with stage("Building the command squid"):
        build.build_command()
    for vehicle in VEHICLES:
        with stage(f"Freezing the design of {vehicle}"):
            run(
                [
                    build.squid(),
                    "design",
                    Path("vehicles") / vehicle,
                    "--out",
                    frozen(vehicle).relative_to(ROOT),
                ]
            )
    with stage("Writing the model descriptions"):
        source, out = Path("vehicles") / DESCRIBED, frozen(DESCRIBED).relative_to(ROOT)
        target = DESCRIPTIONS.relative_to(ROOT)
        run([build.squid(), "package", source, "--out", out, "--descriptions", target])
    return 0
