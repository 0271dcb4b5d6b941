"""A design with `rate`, end to end: proved, packed, verified against its vehicle, simulated."""

from __future__ import annotations

import json
import shutil
from decimal import localcontext
from pathlib import Path

import numpy as np
import pytest
from claims import claim, claims
from conftest import Run, kept, masked
from decimals import DIGITS
from flights import TEN_DEGREES, pitch_step
from fly.package import Packages
from syrupy.assertion import SnapshotAssertion
from test_bounded_rate import why_not

pytestmark = pytest.mark.change

RATE = 0.1
"""m/s^2: of a vehicle that takes 25 s through its range of speed."""


@pytest.fixture(scope="module")
def designed(
    run_squid: Run, squid_by_errors: Path, tmp_path_factory: pytest.TempPathFactory
) -> tuple[Path, Packages]:
    """Return a vehicle with tracking errors only whose design has a rate, and its packages."""
    vehicle = tmp_path_factory.mktemp("rate") / "vehicle"
    shutil.copytree(squid_by_errors, vehicle)
    design = vehicle / "design.toml"
    text = design.read_text(encoding="utf-8")
    assert text.count("[synthesis]\n") == 1
    design.write_text(text.replace("reduce = 0\n", f"rate = {RATE}\n"), encoding="utf-8")
    packages = kept(run_squid, vehicle)
    assert f" {RATE:.3f} m/s^2" in (packages.folder / "design.txt").read_text(encoding="utf-8")
    return vehicle, packages


def test_the_product_claims_the_rate(
    designed: tuple[Path, Packages], run_squid: Run, snapshot: SnapshotAssertion
) -> None:
    """`squid verify` proves the FMU, also against the vehicle, and states the rate for which the smaller gain holds."""
    vehicle, packages = designed
    certificate = json.loads((packages.folder / "certificate.json").read_text(encoding="utf-8"))
    (bounded, robust), half_range = claims(certificate, "rate"), 1.25
    assert bounded["rate"] == pytest.approx(RATE / half_range, rel=1e-12)
    assert bounded["gamma"] < robust["gamma"] < 1.3 * bounded["gamma"]
    assert bounded["gamma"] < claim(certificate, "gain")["gamma"]
    for fmu in (packages.controller, packages.loop):
        done = run_squid("verify", fmu, "--vehicle", vehicle, "--verbose")
        assert done.returncode == 0, done.stderr
        assert all(str(bounded[key]) in done.stdout for key in ("rate", "gamma"))
        found = json.loads(run_squid("verify", fmu, "--vehicle", vehicle, "--json").stdout)
        assert found["gamma_at_rate"] == bounded["gamma"]
    theorem = [line for line in done.stdout.splitlines() if line.startswith("PROVED: ") or "Delta" in line]
    assert masked("\n".join(theorem)) == snapshot
    with localcontext() as context:
        context.prec = DIGITS
        assert why_not(certificate) is None


def test_the_product_flies(designed: tuple[Path, Packages]) -> None:
    """A pitch step of 10 degrees with the FMUs, at the ends and the centre of the speed range."""
    for speed in (0.5, 1.75, 3.0):
        flown = pitch_step(designed[1], speed, TEN_DEGREES, 85.0)
        assert np.max(flown["pitch_done"]) - 1.0 < 0.10
        assert np.max(np.abs(flown["pitch_done"][-400:] - 1.0)) < 0.01
        assert np.max(np.abs(flown["speed_error"])) < 0.05
