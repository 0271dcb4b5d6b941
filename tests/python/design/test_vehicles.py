"""Vehicles other than Squid and REMUS 100: designed, proved, packaged, simulated, and moving as the reference does."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
import reference_plant as reference
from compare_plant import PITCH_TOLERANCE, differences
from conftest import PITCHING, SQUID, Run, designed, in_pitch, kept
from flights import TEN_DEGREES, figures_of, fly_alone, limits, pitch_step, sample_time
from fly.package import Packages
from fly.stages import ROOT

pytestmark = pytest.mark.change

SPEEDS = {"lauv": 1.0, "tethys": 1.0, "sparus2": 0.35}
"""At which each is compared with the reference (m/s). That has no trim for BlueROV2, which can hold any pitch."""
VEHICLES = [*SPEEDS, "bluerov2_heavy"]
ROWS = (ROOT / "docs" / "vehicles.md").read_text(encoding="utf-8").splitlines()
SPREAD = 0.01
"""Of gamma: another processor rounds otherwise, and the search for the controller amplifies that."""


@pytest.fixture(scope="module", params=VEHICLES)
def shipped(request: pytest.FixtureRequest, run_squid: Run) -> Packages:
    """Return the FMUs of each vehicle in turn, designed and packaged in about 10 s."""
    vehicle = ROOT / "vehicles" / request.param
    return kept(run_squid, in_pitch(vehicle) if (vehicle / "pitch.toml").is_file() else vehicle)


def load(packages: Packages, name: str) -> dict:
    return json.loads((packages.folder / name).read_text(encoding="utf-8"))


def test_the_gain_is_proved_and_is_that_of_the_table(shipped: Packages) -> None:
    design = load(shipped, "design.json")
    row = next(line.split("|") for line in ROWS if f"`vehicles/{shipped.vehicle}`" in line)
    assert design["certified"] is True
    assert not [one["key"] for one in design["verdict"]["rows"] if one["outcome"] == "missed"]
    assert design["gamma_bound"] == pytest.approx(float(row[4]), rel=SPREAD)


def test_references_may_ask_for_twice_the_pitch_step(shipped: Packages) -> None:
    """At every speed, up and down: limits are those of the vehicle, and not narrower than the steps of the design."""
    controller, step = load(shipped, "controller.json"), load(shipped, "manoeuvre.json")["steps"]["pitch"]
    level = np.array(controller["trim"]["signals"]["pitch"])
    least, largest = (np.array(end) for end in controller["envelope"]["pitch"]["range"])
    assert np.all(least < level - 2.0 * abs(step)) and np.all(largest > level + 2.0 * abs(step))


@pytest.mark.parametrize("vehicle", [SQUID, PITCHING], ids=["squid", "remus100"])
def test_actuator_use_is_that_of_the_table(vehicle: Path, run_squid: Run, tmp_path: Path) -> None:
    """Largest use over the steps at constant speeds, within 1 of 100."""
    row = next(line.split("|") for line in ROWS if f"`vehicles/{vehicle.name}`" in line)
    out = Path(shutil.copytree(designed(run_squid, vehicle), tmp_path / "out"))
    steps = json.loads(run_squid("simulate", vehicle, "--out", out, "--json").stdout)["steps"]
    assert len(steps) == 6
    found = 100.0 * max(step["actuator_use"] for step in steps)
    assert found == pytest.approx(float(row[8].strip().removesuffix(" %")), abs=1.0)


def test_the_manoeuvre_is_flown_within_the_limits(shipped: Packages, run_squid: Run, tmp_path: Path) -> None:
    """Pitch step while the speed ramps: overshoot and steady error below 10 % and 1 %."""
    flown = fly_alone(shipped.loop, load(shipped, "manoeuvre.json")["duration"], sample_time(shipped))
    (found,) = figures_of(run_squid, flown, tmp_path)["pitch_steps"]
    assert found["overshoot"] < 0.10
    assert found["steady_error"] < 0.01
    for name, (low, high) in limits(shipped).items():
        assert low < np.min(flown[name]), name
        assert np.max(flown[name]) < high, name


def test_it_moves_as_the_reference_does(shipped: Packages) -> None:
    """60 s of propeller steps, saturation and a turning current, compared with SciPy's DOP853 at rtol 1e-10."""
    if shipped.vehicle not in SPEEDS:
        return
    vehicle = reference.read_vehicle(ROOT / "vehicles" / shipped.vehicle / "vehicle.toml")
    found, travelled = differences(shipped.plant, vehicle, speed=SPEEDS[shipped.vehicle], depth=20.0)
    assert travelled > 0.0, "the vehicle must have moved"
    assert found["pitch"] < PITCH_TOLERANCE, found
    assert max(found.values()) < 1e-5, found


def test_a_vehicle_is_flown_astern(run_squid: Run, tmp_path: Path) -> None:
    """BlueROV2 Heavy with reversed speeds: all requirements are met, and both FMUs and their loop simulate it."""
    vehicle = Path(shutil.copytree(ROOT / "vehicles" / "bluerov2_heavy", tmp_path / "vehicle"))
    text = (vehicle / "design.toml").read_text(encoding="utf-8")
    astern = {"speed_min = 0.0": "-0.5", "speed_max = 0.5": "0.0"}
    astern |= {"speed_from = 0.05": "-0.05", "speed_to = 0.45": "-0.45"}
    for ahead, speed in astern.items():
        assert f"\n{ahead}\n" in text
        text = text.replace(f"\n{ahead}\n", f"\n{ahead.split()[0]} = {speed}\n")
    (vehicle / "design.toml").write_text(text, encoding="utf-8")
    packages = kept(run_squid, vehicle)
    design = load(packages, "design.json")
    assert design["certified"] is True
    assert not [one["key"] for one in design["verdict"]["rows"] if one["outcome"] == "missed"]
    flown = fly_alone(packages.loop, load(packages, "manoeuvre.json")["duration"], sample_time(packages))
    assert flown["speed"][-1] == pytest.approx(-0.45, abs=0.01)
    (found,) = figures_of(run_squid, flown, tmp_path)["pitch_steps"]
    assert found["overshoot"] < 0.10 and found["steady_error"] < 0.01
    coupled = pitch_step(packages, -0.3, TEN_DEGREES, 20.0)
    assert coupled["pitch_done"][-1] == pytest.approx(1.0, abs=0.01)
    assert np.max(np.abs(coupled["speed_error"])) < 0.02
