"""Engaging in flight, with the FMUs: after a pilot, after a reset, after another design.

Without following the applied commands, a controller engaged off trim jumped by half of the range of the thrusters.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, field

import numpy as np
import pytest
from conftest import REMUS100, Run, kept
from flights import limits, sample_time
from fly.master import Loop, Slave
from fly.package import Packages

pytestmark = pytest.mark.change

DEGREE = math.pi / 180.0
DEEP = 500.0
"""So deep (m) that no climb reaches the surface."""
MANUAL, AFTER = 4.0, 10.0
"""How long a pilot flies, and how long the controller after (s)."""
PILOT = 0.05
"""How far from trim the pilot's commands are at most, as a share of their ranges."""
LARGEST_JUMP = 0.01
"""Of the range of an actuator."""
EXCURSION = 3.0 * DEGREE
"""A step of which pitch moves by more."""


@pytest.fixture(scope="module")
def deep(run_squid: Run) -> Packages:
    return kept(run_squid, REMUS100, "--axis", "depth")


@pytest.fixture(params=["squid", "remus100", "deep"])
def each(request: pytest.FixtureRequest) -> Packages:
    return request.getfixturevalue(request.param)


@dataclass
class Pilot:
    """Commands about trim that change each second; actuators that the plant cannot distinguish get equal commands."""

    commands: dict[str, float]
    ranges: dict[str, float]
    alike: list[tuple[str, str]]
    random: np.random.Generator
    now: dict[str, float] = field(default_factory=dict)

    @classmethod
    def of(cls, packages: Packages, controller: Slave, seed: int) -> Pilot:
        """Return a pilot of a vehicle in trim."""
        ranges = limits(packages)
        trim = {name: controller.get(name) for name in ranges}
        # The two upper thrusters of Squid act alike in the plane, so that no controller of the plane can distinguish
        # them.
        alike = [("upper_port", "upper_starboard")] if "upper_port" in ranges else []
        widths = {name: high - low for name, (low, high) in ranges.items()}
        return cls(trim, widths, alike, np.random.default_rng(seed))

    def at(self, tick: int) -> dict[str, float]:
        """Return the commands of a tick."""
        if tick % 50 == 0:
            off = {name: self.random.uniform(-PILOT, PILOT) * width for name, width in self.ranges.items()}
            off |= {other: off[one] for one, other in self.alike}
            self.now = {name: self.commands[name] + by for name, by in off.items()}
        return self.now


def speeds(packages: Packages) -> tuple[float, float]:
    design = json.loads((packages.folder / "controller.json").read_text(encoding="utf-8"))
    return design["scheduling"]["minimum"], design["scheduling"]["maximum"]


@dataclass
class Taken:
    """Figures of an engagement."""

    jump: float
    followed: float
    motion: float
    """How far from the pitch that it is to have the vehicle is, and goes in a second by the rate that it has."""
    inside: bool
    """Whether the pilot has left the speed within the range of the design."""
    excursion: float
    """How far pitch goes beyond what lies between the pitch that it has and the one that it is to have."""


def worst(controller: Slave, applied: dict[str, float], ranges: dict[str, float]) -> float:
    """Return the largest difference between a command and the applied one, as a fraction of its range."""
    return max(abs(controller.get(name) - value) / ranges[name] for name, value in applied.items())


def apply(controller: Slave, applied: dict[str, float]) -> None:
    for name, value in applied.items():
        controller.set(f"{name}_applied", value)


class Flight:
    """Plant and controller at a speed along the path, in trim."""

    def __init__(self, packages: Packages, plant: Slave, controller: Slave, speed: float) -> None:
        self.plant, self.controller, self.tick = plant, controller, sample_time(packages)
        plant.begin({"initial_speed": speed, "initial_depth": DEEP, "reference_depth": DEEP})
        controller.begin()
        self.loop = Loop(plant, controller)
        self.wanted = {name: self.measured(name) for name in self.loop.wanted}
        self.loop.inform(self.wanted)
        plant.ready()
        controller.ready()
        self.loop.command()
        self.step = 0

    def measured(self, reference: str) -> float:
        """Return the measured value of a reference."""
        return self.plant.get(reference.removesuffix("_reference"))

    def hold(self) -> None:
        """Set the references to the current measurements."""
        self.wanted = {name: self.measured(name) for name in self.loop.wanted}

    def fly(self, applied: dict[str, float] | None = None) -> None:
        """Simulate one tick, under the controller or with these commands."""
        self.step += 1
        self.loop.inform(self.wanted)
        self.controller.step_to(self.step * self.tick)
        if applied is None:
            self.loop.command()
        else:
            for name, value in applied.items():
                self.plant.set(name, value)
        self.plant.step_to(self.step * self.tick)


def engaged(packages: Packages, seed: int) -> Taken:
    """Let a pilot fly, then engage the controller, which holds the present state."""
    slow, fast = speeds(packages)
    speed = np.random.default_rng(seed + 1_000_000).uniform(slow + 0.1, fast - 0.1)
    with Slave(packages.plant, "plant") as plant, Slave(packages.controller, "controller") as controller:
        flight = Flight(packages, plant, controller, float(speed))
        pilot = Pilot.of(packages, controller, seed)
        controller.set("engaged", False)
        followed = 0.0
        count = round(MANUAL / flight.tick)
        for tick in range(count):
            now = pilot.at(tick)
            apply(controller, now)
            flight.fly(now)
            if tick * flight.tick > 1.0:
                followed = max(followed, worst(controller, now, pilot.ranges))
        controller.set("engaged", True)
        flight.hold()
        begun = plant.get("pitch")
        # A pitch design holds the present state; a depth design returns to level flight.
        end = begun if "pitch_reference" in flight.wanted else plant.get("trim_pitch")
        inside = slow <= plant.get("path_speed") <= fast
        motion = abs(begun - end) + abs(plant.get("pitch_rate"))
        excursion, jump = 0.0, None
        for _ in range(round(AFTER / flight.tick)):
            flight.fly()
            jump = worst(controller, now, pilot.ranges) if jump is None else jump
            pitch = plant.get("pitch")
            excursion = max(excursion, pitch - max(begun, end), min(begun, end) - pitch)
    return Taken(jump, followed, motion, inside, excursion)


def check(packages: Packages, seeds: range) -> None:
    all_taken = [engaged(packages, seed) for seed in seeds]
    jumps, followed = (max(getattr(one, name) for one in all_taken) for name in ("jump", "followed"))
    # Motion left by the pilot is damped first; from a dive a depth design returns to the depth of engagement.
    inside = [one for one in all_taken if one.inside]
    excursions = max(one.excursion - one.motion for one in inside)
    print(f"{len(inside)} of {len(all_taken)} inside, pitch {excursions / DEGREE:.2f} deg")
    print(f"jump {jumps:.2%}, followed {followed:.2%}")
    assert jumps <= LARGEST_JUMP and followed <= LARGEST_JUMP
    assert len(inside) > 0.7 * len(all_taken) and excursions <= EXCURSION


def test_it_takes_over_from_a_pilot(each: Packages) -> None:
    check(each, range(20))


@pytest.mark.night
def test_it_takes_over_from_ten_thousand_pilots(each: Packages) -> None:
    check(each, range(3334))


def test_a_reset_in_flight_is_no_bump(each: Packages) -> None:
    """The vehicle keeps its state, and the commands continue without a jump."""
    slow, fast = speeds(each)
    with Slave(each.plant, "plant") as plant, Slave(each.controller, "controller") as controller:
        flight = Flight(each, plant, controller, 0.5 * (slow + fast))
        key = "pitch_reference" if "pitch_reference" in flight.wanted else "depth_reference"
        flight.wanted[key] += 8.0 * DEGREE if key == "pitch_reference" else 3.0
        for _ in range(round(20.0 / flight.tick)):
            flight.fly()
        applied = {name: controller.get(name) for name in limits(each)}
        ranges = {name: high - low for name, (low, high) in limits(each).items()}
        before = plant.get("pitch")
        controller.fmu.reset()
        controller.fmu.setupExperiment(startTime=controller.time)
        controller.fmu.enterInitializationMode()
        flight.loop.inform(flight.wanted)
        apply(controller, applied)
        controller.set("applied_given", True)
        controller.ready()
        assert worst(controller, applied, ranges) <= LARGEST_JUMP
        excursion = 0.0
        for tick in range(round(AFTER / flight.tick)):
            apply(controller, {name: controller.get(name) for name in applied})
            flight.fly()
            if tick == 0:
                assert worst(controller, applied, ranges) <= LARGEST_JUMP
            excursion = max(excursion, abs(plant.get("pitch") - before))
    assert excursion <= EXCURSION


def test_two_designs_change_places(remus100: Packages, deep: Packages) -> None:
    """Pitch, depth and pitch again: the design that is not engaged follows the commands of the other."""
    ranges = {name: high - low for name, (low, high) in limits(remus100).items()}
    slow, fast = speeds(remus100)
    with (
        Slave(remus100.plant, "plant") as plant,
        Slave(remus100.controller, "pitch") as pitch,
        Slave(deep.controller, "depth") as depth,
    ):
        flight = Flight(remus100, plant, pitch, 0.5 * (slow + fast))
        depth.begin()
        other = Loop(plant, depth)
        wanted = {name: plant.get(name.removesuffix("_reference")) for name in other.wanted}
        other.inform(wanted)
        depth.ready()
        flies, follows = pitch, depth
        for tick in range(round(40.0 / flight.tick)):
            changes = tick in (500, 1250)
            if changes:
                flies, follows = follows, flies
                wanted = {name: plant.get(name.removesuffix("_reference")) for name in other.wanted}
                flight.hold()
                last = {name: follows.get(name) for name in ranges}
            flies.set("engaged", True)
            follows.set("engaged", False)
            apply(follows, {name: flies.get(name) for name in ranges})
            other.inform(wanted)
            flight.loop.inform(flight.wanted)
            end = (tick + 1) * flight.tick
            pitch.step_to(end)
            depth.step_to(end)
            commands = {name: flies.get(name) for name in ranges}
            if changes:
                assert max(abs(commands[name] - last[name]) / ranges[name] for name in ranges) <= LARGEST_JUMP
                begun = plant.get("pitch")
            if tick > 500:
                assert abs(plant.get("pitch") - begun) <= EXCURSION
            for name, value in commands.items():
                plant.set(name, value)
            plant.step_to(end)


@pytest.mark.parametrize("known", [False, True])
def test_limits_beyond_its_own_do_not_wind_it_up(remus100: Packages, known: bool) -> None:
    """Planes stuck at 60 % of their limits, known to the controller or not: it recovers within 10 s."""
    with Slave(remus100.plant, "plant") as plant, Slave(remus100.controller, "controller") as controller:
        flight = Flight(remus100, plant, controller, 1.4)
        controller.set("applied_given", known)
        level = flight.wanted["pitch_reference"]
        low, high = (0.6 * end for end in limits(remus100)["stern_planes"])
        given = {name: controller.get(name) for name in limits(remus100)}
        at_limits, late = 0.0, []
        for tick in range(round(60.0 / flight.tick)):
            time = tick * flight.tick
            flight.wanted["pitch_reference"] = level + (30.0 * DEGREE if 5.0 <= time < 40.0 else 0.0)
            apply(controller, given)
            flight.step += 1
            flight.loop.inform(flight.wanted)
            controller.step_to(flight.step * flight.tick)
            given = {name: controller.get(name) for name in given}
            given["stern_planes"] = min(max(given["stern_planes"], low), high)
            at_limits += flight.tick * (given["stern_planes"] in (low, high))
            for name, value in given.items():
                plant.set(name, value)
            plant.step_to(flight.step * flight.tick)
            if time >= 50.0:
                late.append(abs(plant.get("pitch") - level))
    print(f"told {known}: {at_limits:.1f} s at the limits, then {max(late) / DEGREE:.2f} deg")
    assert at_limits > 10.0
    assert max(late) < 1.0 * DEGREE
