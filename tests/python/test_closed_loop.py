"""What is asked of the closed loop, on the nonlinear vehicle, through the FMUs."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from flights import STEP_TIME, TEN_DEGREES, fly_alone, limits, pitch_step, sample_time
from fly.figures import steps
from fly.master import Signals
from fly.package import Packages

SPEEDS = [0.5, 1.0, 1.5, 2.0, 2.5, 3.0]
"""The speeds of Sutarto and Budiyono (2011), m/s."""
DURATION = 65.0
HELD = 0.05
"""How far the speed may leave its reference during the step, as a part of the highest speed."""


@cache
def response(packages: Packages, speed: float) -> Signals:
    return pitch_step(packages, speed, TEN_DEGREES, DURATION)


@pytest.mark.parametrize("speed", SPEEDS)
def test_pitch_step_at_the_speeds_of_the_paper(squid: Packages, speed: float) -> None:
    """Steady error within the paper's 1 %, overshoot below 10 %, thrust inside its limits, speed held."""
    flown = response(squid, speed)
    after = flown["pitch_done"][flown["time"] >= STEP_TIME]
    assert np.max(after) - 1.0 < 0.10
    tail = after[-len(after) // 10 :]
    assert np.max(np.abs(tail - 1.0)) < 0.01
    for name, (low, high) in limits(squid).items():
        assert low < np.min(flown[name]), name
        assert np.max(flown[name]) < high, name
    assert np.max(np.abs(flown["speed_error"])) < HELD * max(SPEEDS)
    before = flown["pitch_done"][flown["time"] < STEP_TIME]
    assert np.max(np.abs(before)) < 1e-3, "nothing moves before the step"


def test_the_six_responses_lie_close_together(squid: Packages) -> None:
    """At no time do two of the six differ by more than a tenth of the step."""
    all_six = np.array([response(squid, speed)["pitch_done"] for speed in SPEEDS])
    assert np.max(np.ptp(all_six, axis=0)) < 0.10


def test_without_control_the_same_step_of_thrust_is_not_alike(squid: Packages) -> None:
    """Open loop (the paper's Fig. 6) one and the same push of a thruster moves the pitch differently at each speed."""
    ends = []
    for speed in (0.5, 3.0):
        values = {"initial_speed": speed}
        start = fly_alone(squid.plant, 0.01, 0.01, values)
        commands = {name: float(start[f"trim_{name}"][0]) for name in limits(squid)}
        commands["lower"] += 2.0
        flown = fly_alone(squid.plant, 20.0, 0.05, values, lambda _, commands=commands: commands)
        ends.append(np.ptp(flown["pitch"]))
    assert max(ends) > 1.5 * min(ends)


def test_ramp_of_speed_is_well_damped(squid: Packages) -> None:
    """A pitch step while speed ramps from 0.5 to 3 m/s in 20 s."""
    values = {
        "pitch_step": TEN_DEGREES,
        "step_time": 10.0,
        "step_end": 1000.0,
        "speed_from": 0.5,
        "speed_to": 3.0,
        "ramp_start": 10.0,
        "ramp_duration": 20.0,
    }
    flown = fly_alone(squid.loop, 90.0, sample_time(squid), values)
    (found,) = steps(flown["time"], flown["pitch"], flown["pitch_reference_used"])
    assert found.overshoot < 0.10
    assert found.settling_time < 20.0
    assert found.steady_error < 0.01
    error = (flown["pitch_reference_used"] - flown["pitch"]) / TEN_DEGREES
    swings = extremes(error[flown["time"] > 10.5])
    assert all(abs(later) < 0.05 for later in swings[2:]), f"ringing: {swings}"
    assert np.max(np.abs(flown["speed_reference_used"] - flown["speed"])) < HELD * 3.0


def extremes(signal: np.ndarray) -> list[float]:
    """Return the values at which a signal turns, leaving out ripples below a thousandth."""
    turns, last, rising = [], float(signal[0]), None
    extreme = last
    for value in map(float, signal):
        if rising is None:
            if abs(value - last) > 1e-3:
                rising, extreme = value > last, value
        elif (value > extreme) == rising:
            extreme = value
        elif abs(value - extreme) > 1e-3:
            turns.append(extreme)
            rising, extreme = not rising, value
    return turns


def test_remus100_steers_by_its_stern_planes(remus100: Packages) -> None:
    """A second vehicle, designed and packaged by naming its directory, follows a step that its planes can fly."""
    height = TEN_DEGREES / 2
    flown = pitch_step(remus100, 1.9, height, DURATION)
    after = flown["pitch_done"][flown["time"] >= STEP_TIME]
    assert np.max(after) - 1.0 < 0.10
    assert abs(np.mean(after[-len(after) // 10 :]) - 1.0) < 0.02
    assert np.ptp(flown["stern_planes"]) > np.deg2rad(0.1), "the planes move"


def test_leaving_the_scheduled_speeds_is_flagged(squid: Packages) -> None:
    """Asked to fly slower than the design's range, the loop goes on flying and says so."""
    values = {"speed_from": 0.6, "speed_to": 0.3, "ramp_start": 5.0, "ramp_duration": 5.0, "pitch_step": 0.0}
    flown = fly_alone(squid.loop, 60.0, sample_time(squid), values)
    assert np.min(flown["scheduling_parameter"]) == -1.0
    assert np.all(np.isfinite(flown["pitch"]))
    assert np.min(flown["speed"]) < 0.5
