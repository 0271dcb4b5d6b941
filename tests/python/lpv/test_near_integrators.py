"""Plants with poles and zeros at 1e-7 to 1e-5 rad/s and modes of order 1: gamma, its lower bound, findings."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from conftest import Run, kinds
from fly.stages import ROOT

pytestmark = pytest.mark.change

PLANTS = json.loads((ROOT / "tests" / "cases" / "near_integrators.json").read_text(encoding="utf-8"))[
    "plants"
]


@pytest.fixture(scope="module")
def reports(run_squid: Run, tmp_path_factory: pytest.TempPathFactory) -> dict[str, dict]:
    """Return the report on each plant."""
    folder: Path = tmp_path_factory.mktemp("plants")
    found = {}
    for plant in PLANTS:
        path = folder / f"{plant['name']}.json"
        path.write_text(json.dumps({"kind": "hinfsyn", "data": plant["data"]}), encoding="utf-8")
        found[plant["name"]] = json.loads(run_squid("lpv", "synth", path, "--json").stdout)
    return found


@pytest.mark.parametrize("plant", PLANTS, ids=lambda plant: plant["name"])
def test_gamma_is_that_of_slicot(reports: dict[str, dict], plant: dict) -> None:
    """Gamma agrees to a thousandth, the controller's bound is proved, and no existing weight is reported as missing."""
    report = reports[plant["name"]]
    assert report["status"] == "feasible"
    assert report["gamma"] == pytest.approx(plant["slicot_gamma"], rel=1e-3)
    assert not {"unweighted_control", "noiseless_measurement"} & set(kinds(report))


@pytest.mark.parametrize("plant", PLANTS, ids=lambda plant: plant["name"])
def test_a_controller_is_proved_near_gamma(reports: dict[str, dict], plant: dict) -> None:
    """The controller is proved at the requested back-off of a tenth, not farther away."""
    report = reports[plant["name"]]
    assert report["certified_gamma"] <= 1.101 * report["gamma"]


@pytest.mark.parametrize("plant", PLANTS, ids=lambda plant: plant["name"])
def test_no_loop_is_below_the_lower_bound(reports: dict[str, dict], plant: dict) -> None:
    """A gain reported as impossible is reached neither by SLICOT's controller nor by ours."""
    report = reports[plant["name"]]
    lower = report["gamma_lower"]
    assert lower is None or lower <= min(plant["slicot_norm"], report["gamma"], report["certified_gamma"])


def test_most_lower_bounds_are_proved(reports: dict[str, dict]) -> None:
    """The proved lower bound is useful: within a tenth of gamma on most plants."""
    close = [r for r in reports.values() if r["gamma_lower"] and r["gamma_lower"] > 0.9 * r["gamma"]]
    assert len(close) > len(reports) // 2
