"""Vehicles in Python: agreement with the command, progress, Ctrl-C."""

from __future__ import annotations

import csv
import json
import os
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from conftest import REMUS100, SQUID, Run, named
from fly.package import Design, Packages
from fly.stages import ROOT
from syrupy.assertion import SnapshotAssertion
from test_inputs import reasons

pytestmark = pytest.mark.change

WORK = """
import os, sys, time
import squid_lpv as sq
def clock():
    taken = os.times()
    return taken.user + taken.system
try:
    sq.Vehicle.read(sys.argv[1]).design(progress=lambda *event: print(*event, flush=True))
except KeyboardInterrupt:
    print("interrupted", time.monotonic(), flush=True)
    time.sleep(3.0)
    before = clock()
    time.sleep(1.0)
    print("after", clock() - before, flush=True)
"""
IDLE = 0.3
"""Seconds of processor time in a second: a computation that goes on takes one or two."""


def test_models_are_those_of_the_command(sq: ModuleType, run_squid: Run) -> None:
    vehicle = sq.Vehicle.read(SQUID)
    shown = json.loads(run_squid("--json", "show", SQUID, "--speed", "2").stdout)["at_speed"]
    found = vehicle.linearise(2.0)
    assert np.array_equal(found.A, shown["A"]) and np.array_equal(found.B, shown["B"])
    assert found.trim.pitch == shown["trim"]["pitch"] and found.states == shown["states"]
    assert (vehicle.name, vehicle.speeds) == ("squid", (0.5, 3.0))
    of_texts = sq.Vehicle.of(
        *((SQUID / f"{name}.toml").read_text(encoding="utf-8") for name in ("vehicle", "design"))
    )
    assert np.array_equal(of_texts.linearise(2.0).A, found.A)


def test_heading(sq: ModuleType, turning: Packages) -> None:
    """The axis of sway and yaw, in the folder of the main job: its model, its proof, a turn."""
    assert turning.controller.is_file()
    vehicle = sq.Vehicle.read(REMUS100, axis="heading")
    found = vehicle.linearise(1.8)
    assert found.states == ["v", "r", "psi"] and vehicle.actuators == ["rudder"] == found.inputs
    assert found.B[1, 0] < 0.0, "the rudder is positive to port"
    design = sq.Design.read(vehicle, Design(REMUS100, "design").folder / "heading")
    assert design.certificate.verify().gamma == design.gamma < 0.3
    flight = design.simulate({"heading_step": -0.5})
    assert flight["heading"][-1] == pytest.approx(-0.5, abs=1e-3)
    with pytest.raises(sq.InputError, match="heading"):
        design.simulate(sea=(ROOT / "vehicles" / "sea.toml").read_text(encoding="utf-8"))


def test_all_axes_fly_together(
    sq: ModuleType, run_squid: Run, turning: Packages, snapshot: SnapshotAssertion
) -> None:
    """In six degrees of freedom the bits are those of the command; a step of a quantity without an axis is refused."""
    assert turning.controller.is_file()
    autopilot = sq.Autopilot.read(REMUS100, Design(REMUS100, "design").folder)
    assert list(autopilot.axes) == ["depth", "heading"]
    assert all(axis.certificate.verify().gamma == axis.gamma for axis in autopilot.axes.values())
    flight = autopilot.simulate({"heading_step": 0.5})
    assert flight["heading"][-1] == pytest.approx(0.5, abs=1e-3)
    assert flight["depth"][-1] == pytest.approx(21.0, abs=1e-2) and flight.units["roll"] == "rad"
    assert np.abs(flight["roll"]).max() > 1e-3
    steps = [{"pitch_step": 0.1}, {"heading_step": 4.0}]
    calls = {str(step): partial(autopilot.simulate, step) for step in steps}
    assert reasons(sq.InputError, calls) == snapshot
    sea = (ROOT / "vehicles" / "sea.toml").read_text(encoding="utf-8")
    wet = autopilot.simulate({"duration": 20.0}, sea=sea)
    assert {"wave_elevation", "altitude_read"} <= set(wet.columns)


def test_a_design_of_the_command(
    sq: ModuleType, run_squid: Run, squid: Packages, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """The design is read, proved, frozen and simulated, with the bits of the command."""
    design = sq.Design.read(sq.Vehicle.read(SQUID), squid.folder)
    assert design.certificate.verify().gamma == design.gamma
    assert {row["outcome"] for row in design.verdict} <= {"met", "missed", "reported"}
    assert len(design.controller(1.0).A) == len(design.lft.matrices["A"])
    flight = design.simulate()
    run_squid("simulate", SQUID, "--out", squid.folder)
    with (squid.folder / "flight.csv").open(newline="", encoding="utf-8") as file:
        names, *rows = csv.reader(file)
    recorded = dict(zip(names, zip(*rows, strict=True), strict=True))
    for name, values in flight.columns.items():
        heading = f"{name} [{flight.units[name]}]" if flight.units[name] != "1" else name
        assert np.array_equal(values, [float(cell) for cell in recorded[heading]]), name
    short = design.simulate({"duration": 1.0, "pitch_step": 0.05})
    assert short["time"][-1] == pytest.approx(1.0)
    calls = {
        "speed": lambda: design.controller(9.0),
        "size": lambda: design.simulate({"pitch_step": 3.0}),
        "axis": lambda: design.simulate({"depth_step": 1.0}),
    }
    assert reasons(sq.InputError, calls) == snapshot
    design.savemat(tmp_path / "k.mat", [0.5, 1.0, 3.0])
    from scipy.io import loadmat

    held = loadmat(tmp_path / "k.mat", simplify_cells=True)
    assert np.array_equal(held["K"]["a"][:, :, 1], design.controller(1.0).A)


def test_what_is_missing_is_said(sq: ModuleType, tmp_path: Path, snapshot: SnapshotAssertion) -> None:
    vehicle = sq.Vehicle.read(SQUID)
    calls = {
        "vehicle": lambda: sq.Vehicle.read(tmp_path / "nowhere"),
        "design": lambda: sq.Design.read(vehicle, tmp_path),
        "autopilot": lambda: sq.Autopilot.read(REMUS100, tmp_path),
    }
    found = reasons(sq.InputError, calls)
    assert {what: named(words, TMP=tmp_path) for what, words in found.items()} == snapshot
    with pytest.raises(sq.InputError, match=r"vehicle.toml:1: .*'nonsense'"):
        sq.Vehicle.of("nonsense = 1", "")
    with pytest.raises(sq.InputError, match=" 1000 m/s "):
        vehicle.linearise(1e3)


def test_what_progress_raises_ends_the_work(sq: ModuleType) -> None:
    def stop(*_: str) -> None:
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        sq.Vehicle.read(SQUID).design(progress=stop)


@pytest.mark.skipif(os.name == "nt", reason="Ctrl-C is sent as a signal")
def test_ctrl_c_ends_the_work(site: Path) -> None:
    """The call returns within a second, and the work that it started uses no more processor time."""
    variables = {**os.environ, "PYTHONPATH": str(site)}
    words = [sys.executable, "-c", WORK, str(SQUID)]
    with subprocess.Popen(words, env=variables, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        for line in process.stdout:
            if line.startswith("began synthesise"):
                break
        time.sleep(0.5)
        sent = time.monotonic()
        process.send_signal(signal.SIGINT)
        out = dict(line.split() for line in process.stdout.read().splitlines() if line[0] in "ia")
    assert float(out["interrupted"]) - sent < 1.0
    assert float(out["after"]) < IDLE
