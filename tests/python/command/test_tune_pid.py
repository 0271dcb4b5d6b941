"""`squid tune --controller pid`: gains that minimise the proved gain, written as a design that all verbs accept."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
import tomllib
from conftest import PITCHING, REMUS100, ROOT, SQUID, Run, messages, refusal
from syrupy.assertion import SnapshotAssertion

pytestmark = pytest.mark.night


@pytest.fixture
def vehicles(tmp_path: Path) -> Path:
    """Return copies of vehicles, with designs whose weights are fixed."""
    weights = {PITCHING: ROOT / "tests" / "designs" / "remus100_for_pid.toml", SQUID: SQUID / "proved.toml"}
    for vehicle, design in weights.items():
        to = tmp_path / vehicle.name
        to.mkdir()
        shutil.copy(vehicle / "vehicle.toml", to)
        shutil.copy(design, to / "design.toml")
    return tmp_path


@pytest.mark.parametrize(
    ("name", "degree", "most"), [("squid", 0, 0.60), ("remus100", 0, 0.80), ("remus100", 1, 0.70)]
)
def test_the_gain_is_proved(run_squid: Run, vehicles: Path, name: str, degree: int, most: float) -> None:
    vehicle = vehicles / name
    done = run_squid("tune", vehicle, "--controller", "pid", "--degree", degree, "--json", timeout=900.0)
    found = json.loads(done.stdout)
    assert found["frozen_gain"] < found["least_gain"] < most
    # The written gains meet the requirements, at a cost in gain; these weights of REMUS 100 require more delay margin
    # than a PID achieves.
    missed = [row["key"] for row in found["verdict"]["rows"] if row["outcome"] == "missed"]
    assert found["verdict"]["rows"]
    assert done.returncode == (5 if missed else 0), done.stderr
    # Constant gains on Squid lose 27 % of the lowest speed under a moment that its thrusters do not hold.
    assert name == "remus100" or set(missed) <= {"held_speed"}
    assert found["least_gain"] <= found["gain"]
    assert found["against_pid"]
    table = tomllib.loads((vehicle / "tuned.toml").read_text(encoding="utf-8"))["controller"]
    units = {gain["name"]: gain["unit"] for gain in found["gains"]}
    assert units["pitch.kp"] == table["pitch"]["kp"]["unit"] == ("N.m/rad" if name == "squid" else "rad/rad")
    for gain in found["gains"]:
        assert len(gain["coefficients"]) == (1 if gain["unit"] == "1" else degree + 1)
    # The written file is a design of its own, with the same proved gain.
    proved = run_squid("prove", vehicle, "--design", "tuned", "--json")
    assert proved.returncode == 0, proved.stderr
    assert json.loads(proved.stdout)["gain"] == pytest.approx(found["gain"], rel=1e-9)


@pytest.mark.change
def test_what_does_not_go_together_is_refused(
    run_squid: Run, vehicles: Path, snapshot: SnapshotAssertion
) -> None:
    vehicle = vehicles / "remus100"
    for arguments in (["--controller", "pid", "--designs", "3"], ["--degree", "1"], ["--controller", "lead"]):
        assert run_squid("tune", vehicle, *arguments).returncode == 64
    shutil.copy(REMUS100 / "design.toml", vehicle / "both.toml")
    words = ["--design", "both", "--axis", "depth", "--controller", "pid", "--json"]
    done = run_squid("tune", vehicle, *words)
    refusal(done, "no_pid")
    assert messages(done) == snapshot
    assert not (vehicle / "tuned.toml").exists()
