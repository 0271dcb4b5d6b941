"""Requirements on the closed loop, tested on the nonlinear vehicle with the FMUs.

First the design with tracking errors only, at the speeds and bandwidths and with the steady error of 1 % of Sutarto and
Budiyono (2011); then the designs in use, with measurements and a reference model.
"""

from __future__ import annotations

import re
import shutil
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
import tomllib
from conftest import SQUID, Run, kept, without_uncertainty
from flights import (
    STEP_TIME,
    TEN_DEGREES,
    figures_of,
    fly_alone,
    limits,
    pitch_step,
    sample_time,
    speed_step,
)
from fly.master import Signals
from fly.package import Packages
from numpy.typing import NDArray

pytestmark = pytest.mark.change

SPEEDS = [0.5, 1.0, 1.5, 2.0, 2.5, 3.0]
BANDWIDTHS = [0.46, 0.23, 0.1]
Signal = NDArray[np.float64]
HELD = 0.05
"""How far the speed may leave its reference during the step, m/s: a tenth of the lowest speed."""
TOUCHED = {2.9: 0.1}
"""How long a command may be at a limit at a speed, s: there the step takes the lower thruster just to it."""


@dataclass(frozen=True)
class Tuning:
    """A design at one bandwidth (rad/s), and its step responses at all speeds."""

    bandwidth: float
    packages: Packages
    responses: dict[float, Signals]


@pytest.fixture(scope="module", params=BANDWIDTHS)
def tuning(request: pytest.FixtureRequest, run_squid: Run, squid_by_errors: Path) -> Tuning:
    """Design with tracking errors only at each bandwidth in turn and simulate the step at all speeds."""
    packages = kept(run_squid, squid_by_errors, "--bandwidth", str(request.param))
    responses = {speed: pitch_step(packages, speed, TEN_DEGREES, 85.0) for speed in SPEEDS}
    return Tuning(request.param, packages, responses)


@pytest.mark.parametrize("speed", SPEEDS)
def test_pitch_step_at_the_speeds_of_the_paper(tuning: Tuning, speed: float) -> None:
    """Steady error within 1 %, overshoot below 10 %, thrust within its limits, speed held."""
    flown = tuning.responses[speed]
    after = flown["pitch_done"][flown["time"] >= STEP_TIME]
    assert np.max(after) - 1.0 < 0.10
    tail = after[-len(after) // 10 :]
    assert np.max(np.abs(tail - 1.0)) < 0.01
    for name, (low, high) in limits(tuning.packages).items():
        assert low < np.min(flown[name]), name
        assert np.max(flown[name]) < high, name
    assert np.max(np.abs(flown["speed_error"])) < HELD
    before = flown["pitch_done"][flown["time"] < STEP_TIME]
    assert np.max(np.abs(before)) < 1e-3, "nothing moves before the step"


def test_commands_come_as_late_as_the_design_declares(
    run_squid: Run, squid_by_errors: Path, tmp_path: Path
) -> None:
    """Commands come five ticks after the step; the loop, designed for this delay, is as good as without it."""
    vehicle = tmp_path / "late"
    shutil.copytree(squid_by_errors, vehicle)
    design = vehicle / "design.toml"
    text = design.read_text(encoding="utf-8")
    design.write_text(text.replace("sample_time = 0.02", "sample_time = 0.02\ndelay = 0.1"), encoding="utf-8")
    packages = kept(run_squid, vehicle)
    sampled = run_squid("verify", packages.folder / "sampled_certificate.json", "--vehicle", vehicle)
    assert sampled.returncode == 0, sampled.stderr
    assert re.findall(r"(\d+) ticks", sampled.stdout) == ["5"]
    flown = pitch_step(packages, 1.5, TEN_DEGREES, 40.0)
    commands = np.column_stack([flown[name] for name in limits(packages)])
    moved = np.abs(commands - commands[0]).max(axis=1) > 1e-3
    # The tick at the time of the step sees it, and its command is read at the end of that tick's step.
    assert flown["time"][moved][0] == pytest.approx(STEP_TIME + 0.1 + 0.02, abs=0.011)
    assert np.max(flown["pitch_done"]) - 1.0 < 0.10
    assert abs(flown["pitch_done"][-1] - 1.0) < 0.01


def test_the_six_responses_lie_close_together(tuning: Tuning) -> None:
    """At no time do two of the six responses differ by more than a tenth of the step."""
    all_six = np.array([response["pitch_done"] for response in tuning.responses.values()])
    assert np.max(np.ptp(all_six, axis=0)) < 0.10


def test_bandwidth_sets_the_pace(tuning: Tuning) -> None:
    """The rise time is that of a first-order system of the specified bandwidth, or up to three times shorter."""
    flown = tuning.responses[1.5]
    first_order = np.log(9.0) / tuning.bandwidth
    assert first_order / 3.0 < Step.of(flown["time"], flown["pitch_done"]).rise < first_order


@dataclass(frozen=True)
class Step:
    """Figures of a step response, which ends at 1 if all is well."""

    overshoot: float
    steady_error: float
    """The largest in the last tenth."""
    rise: float
    """From 0.1 to 0.9 (s)."""

    @classmethod
    def of(cls, time: Signal, done: Signal) -> Step:
        """Compute the figures of a signal over time (s)."""
        after = done[time >= STEP_TIME]
        reached = [float(time[np.argmax(done > part)]) for part in (0.1, 0.9)]
        steady_error = np.max(np.abs(after[-len(after) // 10 :] - 1.0))
        return cls(float(np.max(after)) - 1.0, float(steady_error), reached[1] - reached[0])


def model_of_pitch(time: Signal, frequency: float, damping: float) -> Signal:
    """Return the step response of T_ref(s) = w^2/(s^2 + 2 zeta w s + w^2)."""
    decay, turning = damping * frequency, frequency * np.sqrt(1.0 - damping**2)
    since = np.maximum(time - STEP_TIME, 0.0)
    swing = np.cos(turning * since) + decay * since * np.sinc(turning * since / np.pi)
    return 1.0 - np.exp(-decay * since) * swing


@pytest.mark.parametrize("speed", [0.6, 1.0, 2.0, 2.9])
def test_squid_follows_pitch_steps(squid: Packages, speed: float) -> None:
    """Steps of 10 degrees: overshoot within 3 %, rise in 2.5 s, steady error within 0.05 %, limits as in `TOUCHED`."""
    flown = pitch_step(squid, speed, TEN_DEGREES, 65.0)
    found = Step.of(flown["time"], flown["pitch_done"])
    assert found.overshoot <= 0.03
    assert found.rise <= 2.5
    assert found.steady_error <= 5e-4
    assert np.max(np.abs(flown["speed_error"])) < HELD
    for name, (low, high) in limits(squid).items():
        at_limit = (flown[name] <= low) | (flown[name] >= high)
        assert np.mean(at_limit) * np.ptp(flown["time"]) <= TOUCHED.get(speed, 0.0), name


SPEED_STEPS = [(0.6, 0.5), (1.5, 0.5), (2.4, 0.5), (1.1, -0.5), (2.9, -0.5)]


@pytest.mark.parametrize(("speed", "height"), SPEED_STEPS)
def test_squid_follows_speed_steps(squid: Packages, speed: float, height: float) -> None:
    """Steps of 0.5 m/s up and down: overshoot within 5 %."""
    flown = speed_step(squid, speed, height, 65.0)
    found = Step.of(flown["time"], flown["speed_done"])
    assert found.overshoot <= 0.05
    assert found.steady_error <= 0.004, "that of the weight"


@pytest.mark.night
def test_the_model_sets_the_pace(squid: Packages, run_squid: Run, tmp_path: Path) -> None:
    """A model of half the frequency halves the pace; halving the bandwidth of the weight has less effect."""
    vehicle = without_uncertainty(SQUID, tmp_path / "vehicle")
    design = vehicle / "design.toml"
    text = design.read_text(encoding="utf-8").replace("\n# anti_windup = true", "\nanti_windup = false")
    assert "\nanti_windup = false" in text, "no limit is reached, and its proof takes most of the time"
    design.write_text(text, encoding="utf-8")
    pace, damping = (tomllib.loads(text)["track"][0][key] for key in ("frequency", "damping"))
    assert text.count(f"frequency = {pace}\ndamping = {damping}\n") == 1

    def flight(packages: Packages, frequency: float) -> tuple[float, float]:
        """Return the rise time relative to that of the model, and the largest deviation from the model."""
        flown = pitch_step(packages, 1.5, TEN_DEGREES, 45.0)
        model = model_of_pitch(flown["time"], frequency, damping)
        own, wanted = (Step.of(flown["time"], done).rise for done in (flown["pitch_done"], model))
        return own / wanted, float(np.max(np.abs(flown["pitch_done"] - model)))

    of_default, apart = flight(squid, pace)
    less_bandwidth, _ = flight(kept(run_squid, vehicle, "--bandwidth", "0.217"), pace)
    design.write_text(text.replace(f"frequency = {pace}", f"frequency = {pace / 2}"), encoding="utf-8")
    slow, _ = flight(kept(run_squid, vehicle), pace / 2)
    print(
        f"rise over that of the model: {of_default:.3f}, half w_b {less_bandwidth:.3f}, half w {slow:.3f}; {apart:.3f}"
    )
    assert 0.9 < of_default < 1.15 and 0.9 < slow < 1.15
    assert less_bandwidth < 1.35
    assert apart < 0.1


def test_without_control_the_responses_are_not_alike(squid: Packages) -> None:
    """The six open-loop responses to a couple of the thrusters (the paper's Fig. 6) differ by a fifth and more."""
    flown = []
    for speed in SPEEDS:
        values = {"initial_speed": speed}
        start = fly_alone(squid.plant, 0.01, 0.01, values)
        couple = {"lower": 1.0, "upper_port": -0.5, "upper_starboard": -0.5}
        commands = {name: float(start[f"trim_{name}"][0]) + couple[name] for name in couple}
        pitch = fly_alone(squid.plant, 30.0, 0.05, values, lambda _, commands=commands: commands)["pitch"]
        flown.append(pitch - pitch[0])
    assert np.max(np.ptp(flown, axis=0)) > 0.2 * np.max(flown)


def test_ramp_of_speed_is_well_damped(squid: Packages, run_squid: Run, tmp_path: Path) -> None:
    """Pitch step while the speed ramps from 0.5 to 3 m/s in 20 s."""
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
    (found,) = figures_of(run_squid, flown, tmp_path)["pitch_steps"]
    assert found["overshoot"] < 0.10
    assert found["steady_error"] < 0.01
    error = (flown["pitch_reference_used"] - flown["pitch"]) / TEN_DEGREES
    assert np.max(np.abs(error[flown["time"] > found["time"] + 20.0])) < 0.05, "within 5 % when the ramp ends"
    swings = extremes(error[flown["time"] > 10.5])
    assert all(abs(later) < 0.05 for later in swings[2:]), f"ringing: {swings}"
    assert np.max(np.abs(flown["speed_reference_used"] - flown["speed"])) < 0.05 * 3.0
    for name, (low, high) in limits(squid).items():
        assert low < np.min(flown[name]), name
        assert np.max(flown[name]) < high, name


def extremes(signal: np.ndarray) -> list[float]:
    """Return the extrema of a signal, except ripples below a thousandth."""
    turns, extreme, rising = [], float(signal[0]), None
    for value in map(float, signal):
        if rising is None:
            if abs(value - extreme) > 1e-3:
                rising, extreme = value > extreme, value
        elif (value > extreme) == rising:
            extreme = value
        elif abs(value - extreme) > 1e-3:
            turns.append(extreme)
            rising, extreme = not rising, value
    return turns


def test_extremes_of_a_known_signal() -> None:
    time = np.arange(0.0, 4.0 * np.pi, 0.01)
    assert extremes(np.sin(time)) == pytest.approx([1.0, -1.0, 1.0, -1.0], abs=1e-4)
    assert extremes(1e-4 * np.sin(time)) == []


@pytest.mark.parametrize("speed", [1.4, 1.5, 1.8, 2.1, 2.2])
def test_remus100_steers_by_its_stern_planes(remus100: Packages, speed: float) -> None:
    """A second vehicle, designed and packaged by the name of its directory, follows the step of its manoeuvre.

    At both ends and the centre of its range, overshoot and steady error are below 10 % and 1 %.
    """
    flown = pitch_step(remus100, speed, np.deg2rad(3.0), 65.0)
    found = Step.of(flown["time"], flown["pitch_done"])
    assert found.overshoot < 0.10
    assert found.steady_error < 0.01
    assert np.ptp(flown["stern_planes"]) > np.deg2rad(0.1), "the planes move"


@pytest.mark.parametrize(("speed", "height"), [(1.5, 0.5), (1.8, 0.3), (2.1, -0.5)])
def test_remus100_follows_speed_steps(remus100: Packages, speed: float, height: float) -> None:
    """Overshoot within 8 %."""
    flown = speed_step(remus100, speed, height, 65.0)
    found = Step.of(flown["time"], flown["speed_done"])
    assert found.overshoot <= 0.08
    assert found.steady_error <= 0.004, "that of the weight"


def test_leaving_the_scheduled_speeds_is_flagged(squid: Packages) -> None:
    """With a reference below the scheduled range the loop continues and sets the flag."""
    values = {"speed_from": 0.6, "speed_to": 0.3, "ramp_start": 5.0, "ramp_duration": 5.0, "pitch_step": 0.0}
    flown = fly_alone(squid.loop, 60.0, sample_time(squid), values)
    assert np.min(flown["scheduling_parameter"]) == -1.0
    assert np.all(np.isfinite(flown["pitch"]))
    assert np.min(flown["speed"]) < 0.5
