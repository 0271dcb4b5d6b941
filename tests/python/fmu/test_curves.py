"""Thrusters with other commands than thrust: Sparus II with the measured curve of a T200, and a square law."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import reference_plant as reference
from compare_plant import PITCH_TOLERANCE, differences
from conftest import Run, kept
from flights import fly_alone, limits, sample_time, start_value
from fly.flight import AGREEMENT
from fly.master import Signals, Slave, couple
from fly.package import Packages
from fly.record import differences as between
from fly.record import references_in
from fly.stages import ROOT
from fmpy import read_model_description
from fmpy.validation import validate_fmu

pytestmark = pytest.mark.change

SPARUS = ROOT / "vehicles" / "sparus2"
CASE = json.loads((ROOT / "tests" / "cases" / "t200_16v.json").read_text(encoding="utf-8"))
T200 = [[float(pulse), 9.80665 * force] for pulse, force in CASE["data"]["points"]]
SQUARE = 4.0727e-6
"""Of the axial thrusters (N/rpm2): a fit to the same measurements ahead."""
SPEED = 0.34
STEP = {"pitch_step": -0.15, "step_time": 5.0, "step_end": 30.0}
"""A pitch step down (rad) and back (s), for which the vertical thruster pushes both ways."""


@pytest.fixture(scope="module")
def plain(run_squid: Run) -> Packages:
    """Return the FMUs of Sparus II as shipped."""
    return kept(run_squid, SPARUS)


@pytest.fixture(scope="module")
def curved_vehicle(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return Sparus II with a T200 as vertical thruster and a square law for the axial ones, with unchanged limits."""
    vehicle = tmp_path_factory.mktemp("curved") / "sparus2"
    vehicle.mkdir()
    (vehicle / "design.toml").write_text(
        (SPARUS / "design.toml").read_text(encoding="utf-8"), encoding="utf-8"
    )
    text = (SPARUS / "vehicle.toml").read_text(encoding="utf-8")
    for name, line in (
        ("axial", f'T_nn = {{ value = {SQUARE}, unit = "N/rpm2", source = "test" }}'),
        ("vertical", f'curve = {{ unit = "us", source = "test", value = {T200} }}'),
    ):
        head = f'name = "{name}"\n'
        assert text.count(head) == 1
        text = text.replace(head, f"{head}{line}\n")
    (vehicle / "vehicle.toml").write_text(text, encoding="utf-8")
    return vehicle


@pytest.fixture(scope="module")
def curved(curved_vehicle: Path, run_squid: Run) -> Packages:
    """Return the FMUs of that vehicle."""
    return kept(run_squid, curved_vehicle)


@pytest.fixture(scope="module")
def flown(curved: Packages) -> Signals:
    """Return the simulation of its closed loop."""
    return fly_alone(curved.loop, 60.0, sample_time(curved), STEP)


def thrust(curved_vehicle: Path, flown: Signals) -> dict[str, np.ndarray]:
    """Return the thrusts that the commands request, by an independent evaluation of the curves."""
    actuators = reference.read_vehicle(curved_vehicle / "vehicle.toml").actuators
    return {one.name: np.array([one.asked(command) for command in flown[one.name]]) for one in actuators}


def test_the_fmus_say_what_they_take(curved: Packages) -> None:
    for fmu in curved.fmus:
        assert not validate_fmu(str(fmu)), fmu
    for fmu in (curved.plant, curved.controller):
        described = read_model_description(str(fmu))
        variables = {one.name: one for one in described.modelVariables}
        assert (variables["vertical"].unit, variables["axial"].unit) == ("us", "rpm")
        units = {one.name: one for one in described.unitDefinitions}
        assert (units["us"].baseUnit.s, units["us"].baseUnit.factor) == (1, 1e-6)
        assert units["rpm"].baseUnit.factor == pytest.approx(2 * np.pi / 60, rel=1e-15)
    (low, high), ends = limits(curved)["vertical"], (T200[0][0], T200[-1][0])
    assert ends[0] < low < high < ends[1], "the limits of the thrust are narrower than the curve"
    assert np.interp([low, high], *np.transpose(T200)) == pytest.approx([-28.5, 28.5], abs=1e-9)
    design = json.loads((curved.folder / "controller.json").read_text(encoding="utf-8"))
    curves = {one["name"]: one["curve"] for one in design["actuators"]}
    assert curves["vertical"] == {"unit": "us", "points": T200}
    assert curves["axial"] == {"unit": "rpm", "square": SQUARE}


def test_the_controller_is_the_same(plain: Packages, curved: Packages) -> None:
    """The controller is designed and proved for thrusts."""
    one, other = (
        json.loads((packages.folder / "controller.json").read_text(encoding="utf-8"))
        for packages in (plain, curved)
    )
    for key in ("lft", "trim", "gamma", "scheduling"):
        assert one[key] == other[key], key


def test_the_flight_is_the_same_but_for_rounding(
    plain: Packages, flown: Signals, curved_vehicle: Path
) -> None:
    """Inverse and curve cancel, also in the dead band, in which the thrust is zero and which is no wider."""
    straight = fly_alone(plain.loop, 60.0, sample_time(plain), STEP)
    found = between(straight, flown)
    left = {name: value for name, value in found.items() if name not in ("axial", "vertical")}
    assert len(left) > 10 and max(left.values()) <= AGREEMENT, left
    for name, asked in thrust(curved_vehicle, flown).items():
        assert np.max(np.abs(asked - straight[name])) < 1e-9, name
    band = CASE["expected"]["dead_band"]
    assert np.min(flown["vertical"]) < band[0] and np.max(flown["vertical"]) > band[1], "it crosses the band"
    inside = (flown["vertical"] > band[0]) & (flown["vertical"] < band[1])
    assert np.all(straight["vertical"][inside] == 0.0)


def test_coupled_is_the_same_flight(curved: Packages, flown: Signals) -> None:
    with Slave(curved.plant, "plant") as plant, Slave(curved.controller, "controller") as controller:
        plant.begin({"initial_speed": float(flown["path_speed"][0])})
        controller.begin()
        end = float(flown["time"][-1])
        found = between(flown, couple(plant, controller, references_in(flown), end, sample_time(curved)))
    assert {"pitch", "speed", "axial", "vertical", "vertical_output"} <= set(found)
    assert max(found.values()) <= AGREEMENT, found


def test_the_plant_moves_as_the_reference_does(curved: Packages, curved_vehicle: Path) -> None:
    vehicle = reference.read_vehicle(curved_vehicle / "vehicle.toml")
    found, travelled = differences(curved.plant, vehicle, speed=SPEED, depth=20.0)
    assert travelled > 0.0
    assert found["pitch"] < PITCH_TOLERANCE, found
    assert max(found.values()) < 1e-5, found


def test_at_rest_it_commands_the_middle_of_the_dead_band(curved: Packages) -> None:
    """The plant gives no thrust for any command in the band, and starts with the trim command outside of it."""
    with Slave(curved.plant, "plant") as plant:
        plant.begin()
        plant.ready()
        trim = plant.get("trim_vertical")
        assert np.interp(start_value(curved.plant, "vertical"), *np.transpose(T200)) == pytest.approx(trim)
        for pulse in (1472.0, 1500.0, 1528.0):
            plant.set("vertical", pulse)
            plant.step_to(plant.time + 10.0)
            assert abs(plant.get("vertical_output")) < 1e-9


def test_figures_and_plot_are_of_thrusts(
    curved_vehicle: Path, plain: Packages, flown: Signals, run_squid: Run, tmp_path: Path
) -> None:
    uses = []
    straight = fly_alone(plain.loop, 60.0, sample_time(plain), STEP)
    for signals, vehicle in ((straight, SPARUS), (flown, curved_vehicle)):
        record = tmp_path / f"{len(uses)}.csv"
        columns = np.column_stack([*signals.values()])
        np.savetxt(record, columns, delimiter=",", header=",".join(signals), comments="")
        done = run_squid("plot", record, "--vehicle", vehicle, "--json")
        assert done.returncode == 0, done.stderr
        uses.append(json.loads(done.stdout)["actuator_use"])
    assert uses[1] == pytest.approx(uses[0], rel=1e-9)


def test_a_controller_for_other_commands_is_refused(
    curved: Packages, curved_vehicle: Path, run_squid: Run, tmp_path: Path
) -> None:
    """A frozen design with an edited curve does not match the vehicle."""
    folder = tmp_path / "out"
    folder.mkdir()
    for path in curved.folder.glob("*.json"):
        (folder / path.name).write_bytes(path.read_bytes())
    design = (folder / "controller.json").read_text(encoding="utf-8")
    assert design.count('"unit": "us"') == 1
    (folder / "controller.json").write_text(design.replace('"unit": "us"', '"unit": "rpm"'), encoding="utf-8")
    done = run_squid("package", curved_vehicle, "--out", folder)
    assert done.returncode != 0
    assert "actuators[0].curve.unit" in done.stderr, done.stderr
