"""Importers that round upward, trap floating-point exceptions, have a small stack, or use messages as formats."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from platform import machine

import numpy as np
import pytest
from fly import platforms
from fly.package import Packages
from native import Plan, Unpacked

pytestmark = pytest.mark.change

KINDS = ["plant", "controller", "loop"]
OWN = platforms.HERE[(sys.platform, machine())]
PLAN = Plan({}, 2.0**-6, 640, 64)
"""Ten seconds; the steps have an exact time, whichever way the importer rounds."""
STACK = 64 * 1024
"""Half of what musl gives a thread."""
traps = pytest.mark.skipif(machine() != "x86_64", reason="most other processors cannot trap")


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    "unusual",
    [
        {"HOST_ROUND_UP": "1"},
        pytest.param({"HOST_TRAP": "1"}, marks=traps),
        {"HOST_STACK": str(STACK)},
    ],
    ids=["rounding", "traps", "stack"],
)
def test_flies_the_same(
    squid: Packages, kind: str, unusual: dict[str, str], host: Path, tmp_path: Path
) -> None:
    unpacked = Unpacked.of(getattr(squid, kind), tmp_path / kind)
    usual = unpacked.flight([host], OWN, PLAN)
    flown = unpacked.flight([host], OWN, PLAN, variables=unusual)
    assert all(np.array_equal(usual[name], flown[name]) for name in usual)


def test_messages_are_formats_of_themselves(squid: Packages, host: Path, tmp_path: Path) -> None:
    """The host prints messages with `vfprintf`: a `%` appears once, and is not a conversion."""
    unpacked = Unpacked.of(squid.loop, tmp_path / "loop")
    words = [host, unpacked.binary(OWN), "100 %s", f"file://{unpacked.folder}/resources", "0.02", "1", "1"]
    done = subprocess.run(list(map(str, words)), capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 1
    assert "fmi2Instantiate: " in done.stderr and done.stderr.count("'100 %s'") == 1
