"""Axes and sensors defined by rows of a table: roll of an X tail, and an altimeter over a rising bottom."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from conftest import REMUS100, Packages, Run, kept, package
from fly.master import Slave, couple, shared
from fmpy import simulate_fmu
from fmpy.validation import validate_fmu

pytestmark = pytest.mark.change

AILERONS = """
[[control_surface]]
name = "ailerons"
K_uu_delta = { value = 2.5, unit = "kg/rad", source = "four fins of an X tail, against one another" }
min = { value = -5.0, unit = "deg", source = "what pitch and yaw leave of the fins" }
max = { value = 5.0, unit = "deg", source = "what pitch and yaw leave of the fins" }
lag = { value = 0.1, unit = "s", source = "as the other two" }
"""

ROLL = """
[[axis]]

[[axis.track]]
output = "roll"
scale = 10.0
unit = "deg"
peak = 1.6
steady_error = 0.01
bandwidth = 0.3
frequency = 0.8
damping = 1.0

[[axis.measure]]
signal = "roll"
scale = 10.0
unit = "deg"
noise = 0.01

[[axis.measure]]
signal = "roll_rate"
scale = 20.0
unit = "deg/s"
noise = 0.5

[axis.control]
weight = 0.1
rise = 4.0
corner = 9.0
disturbance = 0.2
lags = true

[axis.synthesis]
back_off = 0.05

[axis.manoeuvre]
roll_step = 2.0
unit = "deg"

[axis.require]
overshoot = 30.0
"""


def copied(to: Path, vehicle: str = "", axis: str = "") -> Path:
    """Copy REMUS 100, with text appended to its files."""
    shutil.copytree(REMUS100, to)
    for name, more in (("vehicle.toml", vehicle), ("design.toml", axis)):
        path = to / name
        path.write_text(path.read_text(encoding="utf-8") + more, encoding="utf-8")
    return to


@pytest.fixture(scope="module")
def rolling(run_squid: Run, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Packages]:
    """Return REMUS 100 with ailerons, and its packed autopilot of depth, heading and roll."""
    here = tmp_path_factory.mktemp("rolling")
    vehicle = copied(here / "remus100", AILERONS, ROLL)
    return vehicle, package(run_squid, vehicle, here / "out")


def test_a_third_axis_is_a_section_of_a_file(run_squid: Run, rolling: tuple[Path, Packages]) -> None:
    """A third axis is designed, proved, packed, simulated with FMPy, and verified in the FMU."""
    vehicle, packed = rolling
    assert validate_fmu(str(packed.loop)) == []
    ends = {"roll_step": np.radians(3.0), "heading_step": np.radians(-20.0), "depth_step": 0.5}
    flown = simulate_fmu(str(packed.loop), start_values=ends, output=["roll", "heading", "depth", "ailerons"])
    last = flown[-1]
    assert np.degrees(last["roll"]) == pytest.approx(3.0, abs=0.02)
    assert np.degrees(last["heading"]) == pytest.approx(-20.0, abs=0.02)
    assert last["depth"] == pytest.approx(20.5, abs=0.01)
    # Holds against the righting moment.
    assert np.degrees(last["ailerons"]) > 0.3
    done = run_squid("verify", packed.loop, "--vehicle", vehicle, "--json")
    assert done.returncode == 0, done.stderr
    proved = {axis["axis"]: axis["status"] for axis in json.loads(done.stdout)["axes"]}
    assert proved == dict.fromkeys(("depth", "heading", "roll"), "proved")


def test_plant_and_controller_fly_apart(rolling: tuple[Path, Packages]) -> None:
    """The plant has an output for each signal that any axis measures, and a master connects them by name."""
    _, packed = rolling
    speed = 1.8
    wanted = {
        "depth_reference": 20.5,
        "heading_reference": 0.3,
        "roll_reference": 0.04,
        "speed_reference": speed,
    }
    with Slave(packed.plant, "plant") as plant, Slave(packed.controller, "controller") as controller:
        assert set(shared(plant, controller)) >= {"roll", "roll_rate", "heading_rate", "pitch_rate", "depth"}
        plant.begin({"initial_speed": speed})
        controller.begin()
        flown = couple(plant, controller, lambda _k, _t: wanted, 60.0, 0.02)
    for name in ("depth", "heading", "roll"):
        assert flown[name][-1] == pytest.approx(wanted[f"{name}_reference"], abs=2e-3), name


def test_a_third_axis_turns_with_the_others(run_squid: Run, rolling: tuple[Path, Packages]) -> None:
    """Nothing is claimed of three axes together, because the joint proof is for two."""
    vehicle, packed = rolling
    done = run_squid("simulate", vehicle, "--turn", "40", "--out", packed.folder)
    assert done.returncode == 0, done.stderr
    flown = np.genfromtxt(packed.folder / "turn.csv", delimiter=",", names=True, deletechars="")
    assert np.degrees(flown["heading_[rad]"][-1]) == pytest.approx(40.0, abs=0.1)
    assert np.degrees(flown["roll_[rad]"][-1]) == pytest.approx(2.0, abs=0.05)
    assert "PROVED" not in done.stdout
    assert not list(packed.folder.glob("coupling_certificate*"))


def test_an_axis_without_an_actuator_is_refused(run_squid: Run, tmp_path: Path) -> None:
    vehicle = copied(tmp_path / "remus100", axis=ROLL)
    done = run_squid("design", vehicle, "--out", tmp_path / "out")
    assert done.returncode == 1 and "K_uu_delta" in done.stderr, done.stderr
    assert not (tmp_path / "out").exists()


def test_an_altimeter_keeps_the_height_above_a_slope(run_squid: Run, tmp_path: Path) -> None:
    """With altitude in place of depth the vehicle climbs with the bottom; FMU and C use the altitude."""
    vehicle = copied(tmp_path / "remus100")
    path = vehicle / "design.toml"
    text = path.read_text(encoding="utf-8")
    assert text.count('signal = "depth"') == 1
    path.write_text(text.replace('signal = "depth"', 'signal = "altitude"'), encoding="utf-8")
    packed = package(run_squid, vehicle, tmp_path / "out")
    assert validate_fmu(str(packed.loop)) == []
    bottom = {"bottom_depth": 60.0, "bottom_slope_north": -0.03, "bottom_slope_east": 0.01}
    names = ["depth", "altitude", "north", "east"]
    flown = simulate_fmu(str(packed.loop), start_values={**bottom, "heading_step": 0.3}, output=names)
    below = 60.0 - 0.03 * flown["north"] + 0.01 * flown["east"]
    assert flown["altitude"] == pytest.approx(below - flown["depth"], abs=1e-9)
    # A metre nearer to the bottom than at the start, while the bottom has risen by some metres.
    assert flown["altitude"][-1] == pytest.approx(39.0, abs=0.01)
    assert flown["depth"][-1] < 17.0
    done = run_squid("export", vehicle, "--axis", "depth", "--out", packed.folder, "--to", tmp_path / "c")
    assert done.returncode == 0, done.stderr
    header = next((tmp_path / "c").rglob("*.h")).read_text(encoding="utf-8")
    assert re.search(r"_real altitude;", header), header


def test_a_sea_has_a_bottom(run_squid: Run, tmp_path: Path) -> None:
    """The depth of the bottom is that of the file, also for a turning vehicle; a steep bottom is refused."""
    out = tmp_path / "out"
    shutil.copytree(kept(run_squid, REMUS100).folder, out)
    sea = tmp_path / "sea.toml"
    sea.write_text("seed = 1\n[bottom]\ndepth = 45.0\nslope_north = -0.01\n", encoding="utf-8")
    done = run_squid("simulate", REMUS100, "--sea", sea, "--out", out)
    assert done.returncode == 0, done.stderr
    flown = np.genfromtxt(out / "turn.csv", delimiter=",", names=True, deletechars="")
    read = flown["altitude_read_[m]"]
    assert read == pytest.approx(45.0 - 0.01 * flown["north_[m]"] - flown["depth_[m]"], abs=1e-9)
    sea.write_text("seed = 1\n[bottom]\ndepth = 45.0\nslope_north = 2.0\n", encoding="utf-8")
    done = run_squid("simulate", REMUS100, "--sea", sea, "--out", out)
    assert done.returncode == 1 and f"{sea}:4" in done.stderr and "slope_north" in done.stderr, done.stderr
