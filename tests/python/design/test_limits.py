"""Simulations at the limits of the actuators, with the closed-loop FMU, and at the limits of the scheduled speeds.

References beyond the envelope are limited before they reach the controller (test_envelope.py): actuators stay saturated
if they are weaker than the controller knows, and temporarily if references jump.
"""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from flights import fly_alone, limits, sample_time
from fly.master import Slave, couple
from fly.package import Packages
from importers import Signals

pytestmark = pytest.mark.change

DEGREE = math.pi / 180.0
STEP_TIME, STEP_END, END = 5.0, 44.0, 75.0
BACK = 10.0
"""A vehicle is back within this time after its command (s)."""
NEAR = 1.0 * DEGREE


def there_and_back(packages: Packages, speed: float, height: float) -> Signals:
    """Request a pitch at a constant speed for 39 s, and then the trim pitch again."""
    values = {
        "pitch_step": height * DEGREE,
        "step_time": STEP_TIME,
        "step_end": STEP_END,
        "speed_from": speed,
        "speed_to": speed,
    }
    return fly_alone(packages.loop, END, sample_time(packages), values)


def pinned(packages: Packages, flown: Signals) -> float:
    """Return the time for which any command is saturated (s)."""
    at = [(flown[name] <= low) | (flown[name] >= high) for name, (low, high) in limits(packages).items()]
    return float(np.count_nonzero(np.any(at, axis=0))) * sample_time(packages)


@pytest.mark.parametrize("height", [30.0, -30.0])
@pytest.mark.parametrize(
    ("name", "speed"), [("squid", 0.5), ("squid", 3.0), ("remus100", 1.4), ("remus100", 2.2)]
)
def test_it_comes_back_from_what_it_cannot_hold(
    request: pytest.FixtureRequest, name: str, speed: float, height: float
) -> None:
    packages: Packages = request.getfixturevalue(name)
    flown = there_and_back(packages, speed, height)
    error = np.abs(flown["pitch"] - flown["pitch_reference_used"])
    late = flown["time"] > STEP_END + BACK
    assert error[late].max() < NEAR
    assert np.abs(flown["pitch"]).max() < 1.3 * abs(height) * DEGREE


@pytest.mark.parametrize("name", ["squid", "remus100"])
@pytest.mark.parametrize("slower", [True, False])
def test_it_keeps_its_attitude_where_the_speed_reference_jumps_through_the_range(
    request: pytest.FixtureRequest, name: str, slower: bool
) -> None:
    """The thrusters are saturated for seconds, with a pitch step at the same time."""
    packages: Packages = request.getfixturevalue(name)
    design = json.loads((packages.folder / "controller.json").read_text(encoding="utf-8"))
    ends = sorted(design["scheduling"][key] for key in ("minimum", "maximum"))
    inside = 0.02 * (ends[1] - ends[0])
    ends = sorted([ends[0] + inside, ends[1] - inside], reverse=slower)
    height = 10.0 * DEGREE
    jump = {"speed_from": ends[0], "speed_to": ends[1], "ramp_start": STEP_TIME, "ramp_duration": 1e-3}
    step = {"pitch_step": height, "step_time": STEP_TIME, "step_end": 1000.0}
    flown = fly_alone(packages.loop, STEP_TIME + 30.0, sample_time(packages), {**jump, **step})
    error = np.abs(flown["pitch"] - flown["pitch_reference_used"])
    assert error[flown["time"] > STEP_TIME + 25.0].max() < NEAR
    assert error.max() < 3.0 * height


def test_planes_are_asked_for_no_more_than_they_hold(remus100: Packages) -> None:
    """The planes are saturated on the way to the end of the envelope, and not while it is held."""
    flown = there_and_back(remus100, 1.4, 30.0)
    assert 0.0 < pinned(remus100, flown) < 2.0
    held = (flown["time"] > STEP_TIME + 10.0) & (flown["time"] < STEP_END)
    low, high = limits(remus100)["stern_planes"]
    assert np.all((flown["stern_planes"][held] > low) & (flown["stern_planes"][held] < high))
    assert flown["pitch"].max() < 22.0 * DEGREE


def test_planes_that_are_too_weak_do_not_wind_the_controller_up(remus100: Packages) -> None:
    """At 60 % of their limits, unknown to the controller, the planes cannot hold what the envelope allows."""
    flown, at_limits = stuck(remus100, 0.6, 30.0, jumps=False)
    assert at_limits * END > 30.0, "the planes must be at their limit for most of the command"
    assert at_limits * END < STEP_END - STEP_TIME + BACK
    assert flown["pitch"].max() < 22.0 * DEGREE
    level = flown["pitch"][0]
    assert np.abs(flown["pitch"] - level)[flown["time"] > STEP_END + BACK].max() < NEAR


def stuck(packages: Packages, share: float, height: float, *, jumps: bool = True) -> tuple[Signals, float]:
    """Simulate a pitch step and back with actuators limited to a fraction of their range, optionally with speed jumps.

    Return the record, and the fraction of time for which any actuator is at its reduced limit. The controller knows the
    nominal limits only.
    """
    left = {name: (share * low, share * high) for name, (low, high) in limits(packages).items()}
    design = json.loads((packages.folder / "controller.json").read_text(encoding="utf-8"))
    slow, fast = (design["scheduling"][key] for key in ("minimum", "maximum"))
    with Slave(packages.plant, "plant") as plant, Slave(packages.controller, "controller") as controller:
        plant.begin({"initial_speed": slow})
        controller.begin()
        level = plant.get("trim_pitch")
        ends = {plant.variables[name].valueReference: pair for name, pair in left.items()}
        give = plant.fmu.setReal

        def give_what_is_left(references: list[int], values: list[float]) -> None:
            pairs = zip(references, values, strict=True)
            give(references, [float(np.clip(v, *ends[r])) if r in ends else v for r, v in pairs])

        plant.fmu.setReal = give_what_is_left

        def references(_: int, time: float) -> dict[str, float]:
            step = height * DEGREE if STEP_TIME + 5.0 <= time < STEP_END else 0.0
            speed = fast if jumps and STEP_TIME <= time < STEP_END else slow
            return {"pitch_reference": level + step, "speed_reference": speed}

        flown = couple(plant, controller, references, END, sample_time(packages))
    at = [(flown[name] <= low) | (flown[name] >= high) for name, (low, high) in left.items()]
    return flown, float(np.mean(np.any(at, axis=0)))


@pytest.mark.parametrize(("name", "height"), [("squid", 10.0), ("squid", -20.0), ("remus100", 5.0)])
def test_actuators_that_stick_unknown_to_the_controller(
    request: pytest.FixtureRequest, name: str, height: float
) -> None:
    """At 60 % of their limits the vehicle moves as with full limits, and recovers as fast."""
    packages: Packages = request.getfixturevalue(name)
    (whole, _), (weak, at_limits) = (stuck(packages, share, height) for share in (1.0, 0.6))
    assert at_limits > 0.02
    off = np.abs(weak["pitch"] - whole["pitch"])
    assert off.max() < 0.6 * abs(height) * DEGREE
    assert off[weak["time"] > STEP_END + BACK].max() < NEAR
    assert weak["path_speed"][-1] == pytest.approx(whole["path_speed"][-1], abs=0.01)


@pytest.mark.parametrize(
    ("start", "current", "wanted", "end", "flown_at"),
    [(0.6, 0.8, 0.8, -1.0, 0.8), (3.4, 0.0, 3.4, 1.0, 3.0), (3.4, 0.0, 2.8, 1.0, 2.8)],
)
def test_outside_the_range_of_speed_the_nearest_law_flies_and_says_so(
    squid: Packages,
    capfd: pytest.CaptureFixture[str],
    start: float,
    current: float,
    wanted: float,
    end: float,
    flown_at: float,
) -> None:
    """At rest in the water, in a following current, and above the range: rho stays at its end, with flag and warning.

    Out there the loop is simulated, not proved, on the way to the requested speed or to the end of the range; at the
    end itself the warning may repeat.
    """
    given: list[tuple[bool, float]] = []
    with Slave(squid.plant, "plant") as plant, Slave(squid.controller, "controller") as controller:
        plant.begin({"initial_speed": start})
        controller.begin()
        level = plant.get("trim_pitch")
        flag = controller.variables["speed_out_of_range"].valueReference

        def references(_: int, time: float) -> dict[str, float]:
            plant.set("current_horizontal", current if time >= STEP_TIME else 0.0)
            given.append((controller.fmu.getBoolean([flag])[0], controller.get("scheduling_parameter")))
            step = 5.0 * DEGREE if time >= 20.0 else 0.0
            return {"pitch_reference": level + step, "speed_reference": wanted}

        flown = couple(plant, controller, references, 60.0, sample_time(squid))
    outside = [rho for out, rho in given if out]
    assert len(outside) > 10 and set(outside) == {end}
    said = capfd.readouterr().out.count(f"held at {end:g} ")
    if flown_at == wanted:
        assert said == 1 and not given[-1][0]
    else:
        assert 1 <= said < 10 and abs(given[-1][1] - end) < 0.01
    assert flown["path_speed"][-1] == pytest.approx(flown_at, abs=0.01)
    assert flown["pitch"][-1] == pytest.approx(level + 5.0 * DEGREE, abs=0.2 * DEGREE)
    assert np.abs(flown["pitch"]).max() < 30.0 * DEGREE
