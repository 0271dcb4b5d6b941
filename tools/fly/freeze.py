"""The generated files that are committed: frozen design and model descriptions of Squid, and licences of others.

They show a reader what comes out without a build, and a change of any of them in review. A test keeps them fresh.
"""

from __future__ import annotations

from pathlib import Path

from fly import build, licences
from fly.stages import ROOT, run, stage

VEHICLE = "squid"
DESCRIPTIONS = ROOT / "modelDescription"


FROZEN = ROOT / "vehicles" / VEHICLE / "frozen"


def freeze() -> int:
    """Make all generated files anew."""
    vehicle, out = Path("vehicles") / VEHICLE, FROZEN.relative_to(ROOT)
    with stage("Collecting the licences of what is compiled in"):
        licences.write()
    with stage("Building the command squid"):
        build.build_command()
    with stage(f"Freezing the design of {VEHICLE}"):
        run([build.squid(), "design", vehicle, "--out", out])
    with stage("Writing the model descriptions"):
        run(
            [
                build.squid(),
                "package",
                vehicle,
                "--out",
                out,
                "--descriptions",
                DESCRIPTIONS.relative_to(ROOT),
            ]
        )
    return 0
