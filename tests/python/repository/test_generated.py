"""The committed generated files are current; `python3 run.py freeze` regenerates them."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from claims import claim
from conftest import Run
from fly.freeze import DESCRIPTIONS, FROZEN, VEHICLE
from fly.package import Packages
from fly.stages import ROOT

pytestmark = pytest.mark.change

REMEDY = "run `python3 run.py freeze` and commit what it changes"
LIBRARY_ROUNDING = 1e-9
"""Of what is computed without a solver: another C library or processor rounds otherwise."""
SOLVER_ACCURACY = 1e-5
"""Of the gammas. Coefficients changed in their last digit (by 2e-14) moved the least one by 4e-12 at most, the bound of
the loop by 1e-8."""
SPREAD = 1e-3
"""Of the controller and of what follows from it. The same changes moved them by 2e-7 at most, but another processor
rounds every step otherwise."""


def load(path: Path) -> dict:
    return json.loads(path.read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def both(squid: Packages) -> tuple[Path, Path]:
    """Return the committed design, and the same derived anew by the main job, with this command and these files."""
    assert VEHICLE == "squid"
    assert (FROZEN / "controller.json").is_file(), f"{FROZEN} holds no design; {REMEDY}"
    return FROZEN, squid.folder


def assert_close(one: object, other: object, tolerance: float, where: str) -> None:
    """Compare two JSON values; numbers by tolerance relative to 1 or their size, everything else exactly."""
    assert type(one) is type(other), where
    if isinstance(one, dict):
        assert one.keys() == other.keys(), where
        for key in one:
            assert_close(one[key], other[key], tolerance, f"{where}.{key}")
    elif isinstance(one, list):
        assert len(one) == len(other), where
        for index, pair in enumerate(zip(one, other, strict=True)):
            assert_close(*pair, tolerance, f"{where}[{index}]")
    elif isinstance(one, float):
        assert one == pytest.approx(other, rel=tolerance, abs=tolerance), f"{where}; {REMEDY}"
    else:
        assert one == other, f"{where}; {REMEDY}"


def test_plant_and_manoeuvre_are_fresh(both: tuple[Path, Path]) -> None:
    committed, anew = both
    for name in ("plant.json", "manoeuvre.json"):
        assert_close(load(committed / name), load(anew / name), LIBRARY_ROUNDING, name)


def test_controller_is_fresh(both: tuple[Path, Path]) -> None:
    """Gamma and its matrices agree to the accuracy of the solver, all else to rounding."""
    one, other = (load(folder / "controller.json") for folder in both)
    lfts = [one.pop("lft"), other.pop("lft")]
    assert_close(one.pop("gamma"), other.pop("gamma"), SOLVER_ACCURACY, "gamma")
    assert_close(one, other, LIBRARY_ROUNDING, "controller")
    for rho in (-1.0, -0.4, 0.0, 0.7, 1.0):
        for omega in np.logspace(-3, 2, 21):
            committed, anew = (response(lft, rho, omega) for lft in lfts)
            difference = np.linalg.norm(committed - anew, 2) / np.linalg.norm(anew, 2)
            assert difference < SPREAD, f"rho {rho}, {omega} rad/s; {REMEDY}"


def response(lft: dict, rho: float, omega: float) -> np.ndarray:
    """Return K(rho, j omega) of x' = A x + By y + Bt w, u = Cu x + Duy y + Dut w, w = rho (Ct x + Dty y + Dtt w)."""
    m = {key: np.array(value, dtype=float) for key, value in lft.items() if key != "blocks"}
    closed = rho * np.linalg.inv(np.eye(len(m["Dtt"])) - rho * m["Dtt"])
    a, b = m["A"] + m["Bt"] @ closed @ m["Ct"], m["By"] + m["Bt"] @ closed @ m["Dty"]
    c, d = m["Cu"] + m["Dut"] @ closed @ m["Ct"], m["Duy"] + m["Dut"] @ closed @ m["Dty"]
    return d + c @ np.linalg.solve(1j * omega * np.eye(len(a)) - a, b)


def test_a_changed_controller_is_seen(both: tuple[Path, Path]) -> None:
    lft = load(both[0] / "controller.json")["lft"]
    changed = {**lft, "Cu": (np.array(lft["Cu"]) * 1.002).tolist()}
    one, other = response(lft, 0.3, 0.5), response(changed, 0.3, 0.5)
    assert np.linalg.norm(one - other, 2) > SPREAD * np.linalg.norm(one, 2)


def test_figures_are_fresh(both: tuple[Path, Path]) -> None:
    one, other = (load(folder / "design.json") for folder in both)
    for figures in (one, other):
        # The margin of the inequality is tiny, and only its sign counts.
        assert figures.pop("largest_eigenvalue") < 0.0
    for key in ("model_error", "gamma_bound_with_model_error", "fastest_controller_mode", "verdict"):
        assert_close(one.pop(key), other.pop(key), SPREAD, key)
    assert_close(one, other, SOLVER_ACCURACY, "design.json")


def test_model_descriptions_are_fresh(run_squid: Run, tmp_path: Path) -> None:
    """The bytes agree, because they follow from the committed design without the solver."""
    done = run_squid("package", ROOT / "vehicles" / VEHICLE, "--out", FROZEN, "--descriptions", tmp_path)
    assert done.returncode == 0, done.stderr
    made = sorted(tmp_path.glob("*.xml"))
    assert len(made) == 3
    for path in made:
        committed = DESCRIPTIONS / path.name
        assert committed.is_file(), f"{committed} is missing; {REMEDY}"
        assert committed.read_bytes() == path.read_bytes(), f"{committed} is stale; {REMEDY}"


def test_documented_bounds_are_those_proved() -> None:
    """The page on the certificate states the bounds proved of the frozen design, rounded up by at most 1 %."""
    page = (ROOT / "docs" / "certificate.md").read_text(encoding="utf-8")
    rows = [line.split("|") for line in page.splitlines() if line.startswith("| Squid (surrogate) | 1.")]
    figures = load(FROZEN / "design.json")
    frozen = figures["verdict"]["frozen"]
    proved = [
        (
            figures["gamma_bound"],
            figures["gamma_bound_sampled"],
            max(at["gain"] for at in frozen),
            max(at["sampled_gain"][1] for at in frozen),
        ),
        (figures["gamma_bound"], figures["gamma_bound_with_model_error"]),
    ]
    stated = [[float(cell) for cell in row[2:6] if cell.strip()[:1].isdigit()] for row in rows]
    pairs = [
        pair for page, found in zip(stated, proved, strict=True) for pair in zip(page, found, strict=True)
    ]
    for value, bound in pairs:
        assert bound <= value <= 1.01 * bound


def test_documented_pitch_step_is_the_one_proved() -> None:
    """The page on the certificate states the largest pitch step at the limits (deg), rounded down to a tenth."""
    page = (ROOT / "docs" / "certificate.md").read_text(encoding="utf-8")
    (stated,) = (
        float(size) for size in re.findall(r"^\| Squid \(surrogate\) \| ([\d.]+) deg", page, re.MULTILINE)
    )
    inputs = load(FROZEN / "controller.json")["controller_inputs"]
    limits = claim(load(FROZEN / "certificate.json"), "limits")
    assert inputs[limits["input"]]["signal"] == "pitch"
    proved = np.degrees(limits["size"] * inputs[limits["input"]]["scale"])
    assert stated <= proved < stated + 0.2
