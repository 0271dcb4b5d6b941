"""The committed generated files: frozen design and model descriptions of Squid, and third-party licences.

They show the results without a build, and changes of the results in a review. A test checks that they are current.
"""

from __future__ import annotations

from pathlib import Path

import licences

from fly import build
from fly.stages import ROOT, run, stage

VEHICLE = "squid"
DESCRIPTIONS = ROOT / "modelDescription"


FROZEN = ROOT / "vehicles" / VEHICLE / "frozen"


def freeze() -> int:
    """Regenerate all these files."""
    vehicle, out = Path("vehicles") / VEHICLE, FROZEN.relative_to(ROOT)
    with stage("Collecting the licences of the crates compiled in"):
        licences.write()
    with stage("Building the command squid"):
        build.build_command()
    with stage(f"Freezing the design of {VEHICLE}"):
        run([build.squid(), "design", vehicle, "--out", out])
    with stage("Writing the model descriptions"):
        to = DESCRIPTIONS.relative_to(ROOT)
        run([build.squid(), "package", vehicle, "--out", out, "--descriptions", to])
    return 0
