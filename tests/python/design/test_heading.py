"""The heading axis of REMUS 100, and turns of Squid: with the command, an importer of FMUs, and a pilot."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from conftest import REMUS100, SQUID, Run, designed, heading_alone, masked, messages, named, refusal
from fly.master import Slave
from fly.package import Design, design_and_package
from fly.stages import ROOT, StageError
from fmpy import read_model_description
from fmpy.validation import validate_fmu
from syrupy.assertion import SnapshotAssertion

pytestmark = pytest.mark.change

HEADING = ("--axis", "heading")


@pytest.fixture(scope="session")
def packed(run_squid: Run) -> Path:
    """Return the folder of the design with its package."""
    return heading_alone(run_squid)


def test_the_controller_is_packed_alone(run_squid: Run, packed: Path) -> None:
    """The FMU is valid, its proof can be verified, and it has the signals of its axis."""
    fmus = [path.name for path in packed.glob("*.fmu")]
    assert fmus == ["remus100_controller.fmu"] and not list(packed.glob("*.ssp"))
    fmu = packed / fmus[0]
    assert validate_fmu(str(fmu)) == []
    done = run_squid("verify", fmu, "--vehicle", REMUS100, *HEADING)
    assert done.returncode == 0, done.stderr
    inputs = {v.name for v in read_model_description(fmu).modelVariables if v.causality == "input"}
    assert {"heading", "heading_rate", "speed", "heading_reference"} <= inputs
    assert not inputs & {"pitch", "depth", "speed_reference", "pitch_reference"}


class Vehicle:
    """Sway, rate of heading and heading of the linear model at 1.8 m/s, with the lag of the rudder."""

    def __init__(self, run_squid: Run) -> None:
        shown = run_squid("show", REMUS100, "--speed", "1.8", *HEADING, "--json")
        model = json.loads(shown.stdout)["at_speed"]
        assert model["states"] == ["v", "r", "psi"]
        self.a, self.b = np.array(model["A"]), np.array(model["B"])[:, 0]
        self.x, self.rudder = np.zeros(3), 0.0

    def advance(self, command: float, steps: int = 10, tick: float = 0.02) -> None:
        """Simulate a tick under a held command (rad)."""
        for _ in range(steps):
            step = tick / steps
            self.rudder += step * (command - self.rudder) / 0.1
            self.x = self.x + step * (self.a @ self.x + self.b * self.rudder)


@pytest.mark.parametrize(
    ("start", "reference", "way"), [(170.0, 190.0, 20.0), (170.0, -170.0, 20.0), (-179.0, 179.0, -2.0)]
)
def test_it_turns_the_shorter_way_through_a_compass_that_wraps(
    run_squid: Run, packed: Path, start: float, reference: float, way: float
) -> None:
    vehicle = Vehicle(run_squid)

    def look() -> None:
        psi = np.deg2rad(start) + vehicle.x[2]
        controller.set("heading", (psi + np.pi) % (2.0 * np.pi) - np.pi)
        controller.set("heading_rate", vehicle.x[1])

    largest = 0.0
    with Slave(packed / "remus100_controller.fmu", "heading") as controller:
        controller.begin({"speed": 1.8, "heading_reference": np.deg2rad(reference)})
        look()
        controller.ready()
        for tick in range(1, 2001):
            look()
            controller.step_to(0.02 * tick)
            vehicle.advance(controller.get("rudder"))
            largest = max(largest, abs(np.rad2deg(vehicle.x[2])))
    turned = np.rad2deg(vehicle.x[2])
    assert turned == pytest.approx(way, abs=0.02 * abs(way)), f"{turned} deg"
    assert largest < 1.02 * abs(way) + 0.01


def test_both_axes_fly_in_six_degrees_of_freedom(run_squid: Run, packed: Path, tmp_path: Path) -> None:
    """A turn of 60 degrees with a depth step, in a current: the effect on each axis, and the joint loop in turns."""
    assert packed.is_dir()
    words = ["simulate", REMUS100, "--current", "0.43,0.25", "--json"]
    done = run_squid(*words, "--out", tmp_path, timeout=900.0)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    turns, coupling = found["turns"], found["coupling"]
    assert len(turns) == 6 and turns[0]["speed"] == 1.4 and turns[-1]["speed"] == 2.2
    for turn in turns:
        assert turn["settling_time"] < 12.5 and turn["overshoot"] < 0.02, turn
        assert turn["depth_by_turn"] < 0.01 and turn["roll"] < np.deg2rad(5.0), turn
        assert np.deg2rad(6.8) < turn["fastest"] <= np.deg2rad(8.001), turn
        assert turn["stable_to"] == pytest.approx(turn["fastest"]), turn
    assert coupling["rates_deg"] == pytest.approx([10.2, 12.0], abs=0.05) and max(coupling["gains"]) < 1.0
    for name in ("coupling_certificate.json", "coupling_certificate_2.json"):
        again = run_squid("verify", tmp_path / name, "--json")
        assert again.returncode == 0 and json.loads(again.stdout)["gamma"] in coupling["gains"], again.stderr
    columns = (tmp_path / "turn.csv").read_text(encoding="utf-8").splitlines()[0].split(",")
    assert {"heading [rad]", "heading_reference_used [rad]", "north [m]", "east [m]", "depth [m]"} <= set(
        columns
    )
    assert (tmp_path / "turn.svg").is_file()


def test_squid_turns_by_two_of_its_thrusters(
    run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """Turns with pitch steps of 10 degrees stay within the 15 N reserved for them; other thrusters never yaw it."""
    both = ("--design", "heading")
    made = designed(run_squid, SQUID, *both)
    printed = (made / "design.txt").read_text(encoding="utf-8")
    (ended,) = (line for line in printed.splitlines() if "simulations end" in line)
    assert masked(ended) == snapshot
    out = Path(shutil.copytree(made, tmp_path / "out"))
    done = run_squid("simulate", SQUID, *both, "--json", "--out", out, timeout=900.0)
    assert done.returncode == 0, done.stderr
    turns = json.loads(done.stdout)["turns"]
    assert len(turns) == 6 and turns[0]["speed"] == 0.5 and turns[-1]["speed"] == 3.0
    for turn in turns:
        assert turn["settling_time"] < 30.0 and turn["overshoot"] < 0.01, turn
        assert turn["depth_by_turn"] < 0.02 and turn["roll"] < np.deg2rad(5.0), turn
        assert np.deg2rad(2.3) < turn["stable_to"] < np.deg2rad(10.01), turn
    flown = np.genfromtxt(out / "turn.csv", delimiter=",", names=True, deletechars="")
    yaw, port, starboard = (flown[f"{name}_[N]"] for name in ("yaw", "upper_port", "upper_starboard"))
    assert 5.0 < np.max(np.abs(yaw)) < 15.0
    assert port == pytest.approx(starboard, abs=1e-6)


@pytest.mark.parametrize(
    ("words", "key", "code"),
    [
        (["--turn", "0"], "argument", 64),
        (["--turn", "-180"], "argument", 64),
        (["--current", "0.3"], "usage", 64),
        ([*HEADING, "--turn", "30"], "usage", 64),
        (["--design", "pitch", "--turn", "30"], "argument", 64),
        (["--axis", "pitch"], "no_axis", 1),
        (["--design", "none"], "no_design", 1),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_what_cannot_be_flown_says_why(
    run_squid: Run, tmp_path: Path, words: list[str], key: str, code: int, snapshot: SnapshotAssertion
) -> None:
    done = run_squid("simulate", REMUS100, "--out", tmp_path, *words, "--json")
    refusal(done, key, code)
    assert messages(done) == snapshot
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("verb", ["simulate", "report", "campaign"])
def test_a_sea_is_refused(run_squid: Run, tmp_path: Path, verb: str, snapshot: SnapshotAssertion) -> None:
    sea = ROOT / "vehicles" / "sea.toml"
    done = run_squid(verb, REMUS100, *HEADING, "--out", tmp_path, "--sea", sea, "--json")
    refusal(done, "sea_of_heading")
    assert messages(done) == snapshot
    assert not list(tmp_path.iterdir())


def test_the_main_job_says_what_flies_heading(
    squid_command: Path, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """A design of heading alone is packed as a controller."""
    assert squid_command.is_file()
    with pytest.raises(StageError) as refused:
        design_and_package(Design(ROOT / "tests" / "vehicles" / "nps_auv_ii", "heading"), tmp_path, [])
    assert named(str(refused.value), TMP=tmp_path) == snapshot


@pytest.mark.parametrize("verb", [["prove"], ["tune", "--controller", "pid"]])
def test_what_takes_one_axis_says_which_there_are(
    run_squid: Run, tmp_path: Path, verb: list[str], snapshot: SnapshotAssertion
) -> None:
    done = run_squid(*verb, REMUS100, "--json", cwd=tmp_path)
    refusal(done, "several_axes")
    assert messages(done) == snapshot(name="message")
    assert not list(tmp_path.iterdir())


def test_every_verb_takes_a_design_of_heading(
    run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """The report has no section on pitch, and records have the signals of the axis."""
    folder = designed(run_squid, REMUS100, *HEADING)
    for verb in (["export"], ["simulate"], ["report"], ["campaign", "--flights", "4"]):
        copy = tmp_path / verb[0] / "heading"
        copy.mkdir(parents=True)
        for path in folder.glob("*.json"):
            (copy / path.name).write_bytes(path.read_bytes())
        done = run_squid(*verb, REMUS100, "--out", copy.parent, *HEADING, timeout=900.0)
        assert done.returncode == 0, done.stderr
    assert (tmp_path / "export" / "c" / "heading" / "remus100_heading.c").is_file()
    header = (tmp_path / "export" / "c" / "heading" / "remus100_heading.h").read_text(encoding="utf-8")
    assert "\n".join(line for line in header.splitlines() if "positive deflection" in line) == snapshot
    columns = (tmp_path / "simulate" / "heading" / "flight.csv").read_text(encoding="utf-8").splitlines()[0]
    assert columns.startswith("time [s],heading [rad],heading_reference_used [rad],speed [m/s]")
    page = (tmp_path / "report" / "heading" / "report.html").read_text(encoding="utf-8")
    assert "heading step" in page and "pitch step" not in page and "pitch after a gust" not in page
