"""Sensor failures in flight, with the FMUs: behaviour without the sensor, and its recovery.

Without monitoring, a depth reading of 0 pitched REMUS 100 down by 66 deg, a speed reading of 0 gave full thrust, and a
frozen pitch made it tumble.
"""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from conftest import REMUS100, Run, kept
from flights import limits
from fly.master import Slave
from fly.package import Packages
from fmpy.fmi1 import FMICallException
from test_engagement import DEGREE, Flight, speeds

pytestmark = pytest.mark.change

OK, LIMITED, SPEED_LOST, RECKONED, FAILED = range(1, 6)
STALE_AFTER = 0.5
NOISE = {"pitch": 0.1 * DEGREE, "pitch_rate": 0.1 * DEGREE, "speed": 0.01, "depth": 0.02}
"""Of the sensors, standard deviations (rad, rad/s, m/s, m)."""
AT, HEIGHT = 12.0, {"pitch_reference": 8.0 * DEGREE, "depth_reference": 4.0}
"""When a step is asked (s), and how high it is (rad, m)."""
BACK = 0.02
"""The largest change of a command in the tick in which a sensor comes back, of its range."""


@pytest.fixture(scope="module")
def deep(run_squid: Run) -> Packages:
    return kept(run_squid, REMUS100, "--axis", "depth")


@dataclass
class Flown:
    """A record, with one entry for each tick."""

    time: np.ndarray
    values: dict[str, np.ndarray]
    status: np.ndarray
    commands: np.ndarray
    """As a share of the range of each actuator."""
    measured: set[str]

    def during(self, start: float, end: float) -> np.ndarray:
        """Return True for each tick within an interval of time (s)."""
        return (start - 1e-9 <= self.time) & (self.time < end - 1e-9)

    def change(self, tick: int) -> float:
        """Return the largest change of a command in a tick."""
        return float(np.abs(self.commands[tick] - self.commands[tick - 1]).max())

    def back(self) -> list[int]:
        """Return the ticks in which a sensor is accepted again."""
        lost = self.status >= SPEED_LOST
        return [int(tick) for tick in np.flatnonzero(lost[:-1] & ~lost[1:]) + 1]


Fault = Callable[[float, dict[str, float]], dict[str, float]]
"""Time (s) and what is measured to what the controller gets instead."""


def fly(packages: Packages, speed: float, fault: Fault, duration: float, *, step: bool = True) -> Flown:
    """Simulate a step with sensor noise and a fault."""
    random = np.random.default_rng(1)
    ranges = limits(packages)
    kept: dict[str, list[float]] = {name: [] for name in ("pitch", "speed", "depth")}
    status, commands = [], []
    with (
        Slave(packages.plant, "plant") as plant,
        Slave(packages.controller, "controller", quiet=True) as controller,
    ):
        flight = Flight(packages, plant, controller, speed)
        controller.set("stale_after", STALE_AFTER)
        level = dict(flight.wanted)
        noise = {name: size for name, size in NOISE.items() if name in controller.variables}
        ticks = round(duration / flight.tick)
        for tick in range(ticks):
            time = tick * flight.tick
            off = HEIGHT if step and time >= AT else {}
            flight.loop.inform({name: value + off.get(name, 0.0) for name, value in level.items()})
            read = {name: plant.get(name) + random.normal(0.0, size) for name, size in noise.items()}
            for name, value in (read | fault(time, read)).items():
                controller.set(name, value)
            controller.step_to((tick + 1) * flight.tick)
            flight.loop.command()
            status.append(controller.get("status"))
            commands.append([controller.get(name) / (high - low) for name, (low, high) in ranges.items()])
            plant.step_to((tick + 1) * flight.tick)
            for name, values in kept.items():
                values.append(plant.get(name))
    values = {name: np.array(each) for name, each in kept.items()}
    return Flown(np.arange(ticks) * flight.tick, values, np.array(status), np.array(commands), set(noise))


def between(start: float, end: float, **values: float) -> Fault:
    """Return a fault that replaces measurements during an interval."""
    return lambda time, _: values if start <= time < end else {}


def invalid(start: float, end: float, name: str) -> Fault:
    """Return a fault that marks a measurement as invalid during an interval."""
    return lambda time, _: {f"{name}_valid": not start <= time < end}


def frozen(start: float, end: float, *names: str) -> Fault:
    """Return a fault that freezes measurements."""
    held: dict[str, float] = {}

    def fault(time: float, read: dict[str, float]) -> dict[str, float]:
        if not start <= time < end:
            held.clear()
            return {}
        held.update({name: held.get(name, read[name]) for name in names})
        return held

    return fault


def safe(packages: Packages) -> np.ndarray:
    """Return the safe commands, as a fraction of the range of each actuator."""
    design = json.loads((packages.folder / "controller.json").read_text(encoding="utf-8"))
    widths = [high - low for low, high in limits(packages).values()]
    return np.array(design["failsafe"]["safe"]) / widths


def each_speed(packages: Packages) -> list[float]:
    slow, fast = speeds(packages)
    return [slow + part * (fast - slow) for part in (0.1, 0.5, 0.95)]


@pytest.fixture(params=["squid", "remus100", "deep"])
def each(request: pytest.FixtureRequest) -> Packages:
    return request.getfixturevalue(request.param)


def test_noise_is_no_fault(each: Packages) -> None:
    for speed in each_speed(each):
        assert fly(each, speed, lambda *_: {}, 30.0).status.max() <= LIMITED


@pytest.mark.parametrize("reads", ["zero", "frozen", "invalid"])
def test_without_the_speed(each: Packages, reads: str) -> None:
    """For 30 s, including a step of the reference: the speed is kept within 20 %."""
    fault = {
        "zero": between(10.0, 40.0, speed=0.0),
        "frozen": frozen(10.0, 40.0, "speed"),
        "invalid": invalid(10.0, 40.0, "speed"),
    }[reads]
    for speed in each_speed(each):
        flown = fly(each, speed, fault, 50.0)
        off = np.abs(flown.values["speed"] - flown.values["speed"][0]).max() / speed
        print(f"{speed:.2f} m/s: {off:.1%}, back {[flown.change(tick) for tick in flown.back()]}")
        assert off < 0.2
        lost = flown.during(10.0 + (STALE_AFTER + 0.02 if reads == "frozen" else 0.0), 40.0)
        assert (flown.status[lost] == SPEED_LOST).all()
        assert flown.status[flown.during(41.0, 50.0)].max() <= LIMITED
        assert [flown.change(tick) for tick in flown.back()] < [BACK] and len(flown.back()) == 1


@pytest.mark.parametrize("step", [False, True])
@pytest.mark.parametrize("reads", ["zero", "invalid"])
def test_without_the_depth(deep: Packages, reads: str, step: bool) -> None:
    """For 10 s: depth is kept within 3 m, and pitch within 5 deg of level flight; a dive ends level."""
    fault = {
        "zero": between(15.0, 25.0, depth=0.0),
        "invalid": invalid(15.0, 25.0, "depth"),
    }[reads]
    for speed in each_speed(deep):
        flown = fly(deep, speed, fault, 45.0, step=step)
        lost = flown.during(15.0, 25.0)
        assert (flown.status[lost] == RECKONED).all()
        depth, pitch = (flown.values[name][lost] for name in ("depth", "pitch"))
        moved, last = np.abs(depth - depth[0]).max(), abs(pitch[-1] - flown.values["pitch"][0])
        tilt = np.abs(pitch - flown.values["pitch"][0]).max()
        print(f"{speed:.2f} m/s: {moved:.2f} m, {tilt / DEGREE:.2f} deg, at the end {last / DEGREE:.2f} deg")
        assert moved < 3.0 and last < 5.0 * DEGREE
        assert step or tilt < 5.0 * DEGREE
        assert [flown.change(tick) for tick in flown.back()] < [BACK] and len(flown.back()) == 1
        goal = flown.values["depth"][0] + (HEIGHT["depth_reference"] if step else 0.0)
        assert abs(flown.values["depth"][-1] - goal) < 0.3


RATES = {
    "frozen": (frozen(13.0, 25.0, "pitch", "pitch_rate"), STALE_AFTER),
    "rate": (between(13.0, 25.0, pitch_rate=-3.0), 0.0),
}


@pytest.mark.parametrize("which", RATES)
def test_without_the_rate_of_pitch(each: Packages, which: str) -> None:
    """During a step the commands reach the safe ones within a second, nothing tumbles, and control resumes later."""
    fault, found = RATES[which]
    for speed in each_speed(each):
        flown = fly(each, speed, fault, 60.0)
        assert (flown.status[flown.during(13.0 + found + 0.02, 25.0)] == FAILED).all()
        at_end = flown.during(13.0 + found + 0.54, 25.0)
        assert np.abs(flown.commands[at_end] - safe(each)).max() < 1e-9
        pitch = flown.values["pitch"] - flown.values["pitch"][0]
        print(f"{speed:.2f} m/s: {np.abs(pitch).max() / DEGREE:.1f} deg")
        assert np.abs(pitch).max() < 35.0 * DEGREE
        assert [flown.change(tick) for tick in flown.back()] < [BACK] and len(flown.back()) == 1
        # A depth design has come up to its depth, or dives to it again.
        wanted = 0.0 if "depth" in flown.measured else HEIGHT["pitch_reference"]
        assert abs(pitch[-1] - wanted) < 1.5 * DEGREE


@pytest.mark.parametrize(
    ("fault", "comes_back"),
    [(between(13.0, 25.0, pitch=0.8), False), (invalid(13.0, 25.0, "pitch"), True)],
    ids=["wrong", "invalid"],
)
def test_without_pitch(each: Packages, fault: Fault, comes_back: bool) -> None:
    """During a step pitch is integrated from its rate. A wrong sensor must agree while the vehicle pitches by 5 deg."""
    for speed in each_speed(each):
        flown, whole = fly(each, speed, fault, 60.0), fly(each, speed, lambda *_: {}, 60.0)
        assert (flown.status[flown.during(13.0, 25.0)] == RECKONED).all()
        pitch = flown.values["pitch"][flown.during(25.0, 60.0)]
        moved = np.abs(pitch - pitch[0]).max()
        print(f"{speed:.2f} m/s: pitched by {moved / DEGREE:.2f} deg after the fault")
        agrees = comes_back or moved > 5.0 * DEGREE
        assert (flown.status[flown.during(26.0, 60.0)] == RECKONED).all() != agrees
        off = np.abs(flown.values["pitch"] - whole.values["pitch"]).max()
        print(f"{speed:.2f} m/s: {off / DEGREE:.2f} deg")
        assert off < 2.0 * DEGREE
        assert [flown.change(tick) for tick in flown.back()] < [BACK]


def test_masters_with_long_steps_are_no_fault(squid: Packages) -> None:
    """Signals arrive ten times a second, the first ones far from the start values."""
    with Slave(squid.controller, "controller") as controller:
        controller.begin()
        controller.ready()
        assert controller.get("status") == OK
        for step, phase in enumerate(np.arange(0.0, 20.0, 0.1)):
            controller.set("speed", 0.6 + 0.3 * (1.0 - math.cos(phase)))
            controller.set("pitch", 0.3 * math.sin(phase))
            controller.set("pitch_rate", 0.3 * math.cos(phase))
            controller.step_to(0.1 * (step + 1))
            assert controller.get("status") <= LIMITED


def test_no_derivatives_without_a_sensor(squid: Packages) -> None:
    """Derivatives are refused if the next tick lacks a sensor: it is marked invalid, or jumps."""
    with Slave(squid.controller, "controller", quiet=True) as controller:
        controller.begin()
        controller.ready()
        controller.step_to(0.02)
        (of,), (by,) = controller.references(["lower"]), controller.references(["pitch"])

        def derive() -> float:
            return controller.fmu.getDirectionalDerivative([of], [by], [1.0])[0]

        assert derive() != 0.0
        for name, value, back in (("speed_valid", 0.0, 1.0), ("pitch", 0.8, controller.get("pitch"))):
            controller.set(name, value)
            with pytest.raises(FMICallException):
                derive()
            controller.set(name, back)
            assert derive() != 0.0


def test_a_state_restored_knows_its_sensors(squid: Packages) -> None:
    """A state saved while a sensor is lost continues with the same bits."""
    with Slave(squid.controller, "controller") as controller:
        controller.begin()
        controller.ready()
        names = controller.names("output")
        numbers = controller.references(names)

        def run(ticks: range) -> list[list[float]]:
            rows = []
            for tick in ticks:
                controller.set("speed_valid", tick > 60)
                controller.set("pitch_valid", not 20 < tick < 30)
                controller.set("pitch", 0.01 * math.sin(tick))
                controller.step_to((tick + 1) * 0.02)
                rows.append([*controller.fmu.getReal(numbers), controller.get("status")])
            return rows

        run(range(25))
        state = controller.fmu.getFMUState()
        first = run(range(25, 120))
        controller.fmu.setFMUState(state)
        controller.time = 0.5
        assert run(range(25, 120)) == first
        assert {row[-1] for row in first} >= {SPEED_LOST, RECKONED}
        changes = [abs(b[0] - a[0]) for a, b in itertools.pairwise(first)]
        assert max(changes) > 0.0
