"""The plant: accuracy, step sizes, fidelities, parallel instances."""

from __future__ import annotations

import numpy as np
import pytest
import reference_plant as reference
from compare_plant import PITCH_TOLERANCE, differences
from flights import fly_alone, limits, start_value
from fly.master import Slave
from fly.package import Packages
from fly.stages import ROOT

pytestmark = pytest.mark.change

STEPS = [0.01, 0.02, 0.1, 0.00999999999999934, 1 / 3, 0.0371]
LPV = 2


def vehicle_of(packages: Packages) -> reference.Vehicle:
    return reference.read_vehicle(ROOT / "vehicles" / packages.vehicle / "vehicle.toml")


@pytest.mark.parametrize("speed", [0.7, 1.75, 2.9])
def test_squid_moves_as_the_reference_does(squid: Packages, speed: float) -> None:
    """60 s of thruster steps, saturation and a turning current, compared with SciPy's DOP853 at rtol 1e-10."""
    found, travelled = differences(squid.plant, vehicle_of(squid), speed=speed)
    assert np.rad2deg(travelled) > 5.0, "the vehicle must have moved"
    assert found["pitch"] < PITCH_TOLERANCE, found
    assert max(found.values()) < 1e-5, found


def test_remus100_moves_as_the_reference_does(remus100: Packages) -> None:
    found, _ = differences(remus100.plant, vehicle_of(remus100), speed=1.6, depth=20.0)
    assert found["pitch"] < PITCH_TOLERANCE, found
    assert max(found.values()) < 1e-5, found


def test_parameters_change_the_vehicle(squid: Packages) -> None:
    """A coefficient set in the FMU has the effect that it has in the reference."""
    found, _ = differences(squid.plant, vehicle_of(squid), parameters={"z_G": 0.02, "X_u_dot": -5.0})
    assert found["pitch"] < PITCH_TOLERANCE, found


def push(packages: Packages, fraction: float) -> dict[str, float]:
    """Return the trim commands with the first actuator moved by a fraction of its range."""
    with Slave(packages.plant, "trim") as plant:
        plant.begin()
        plant.ready()
        bounds = limits(packages)
        commands = {name: plant.get(f"trim_{name}") for name in bounds}
    first = next(iter(bounds))
    commands[first] += fraction * (bounds[first][1] - bounds[first][0])
    return commands


@pytest.mark.parametrize("step", STEPS)
def test_motion_does_not_depend_on_the_communication_step(packages: Packages, step: float) -> None:
    """Held inputs: the vehicle ends at the same state for all step sizes, multiples of the integrator's step or not."""
    commands = push(packages, 0.1)
    base = fly_alone(packages.plant, 20.0, 0.05, inputs=lambda _: commands)
    other = fly_alone(packages.plant, 20.0, step, inputs=lambda _: commands)
    for name in base:
        scale = max(1.0, abs(base[name][-1]))
        assert other[name][-1] == pytest.approx(base[name][-1], abs=1e-8 * scale), name


def small_and_large(packages: Packages, fidelity: int) -> tuple[np.ndarray, np.ndarray]:
    speed = start_value(packages.plant, "initial_speed")
    values = {"fidelity": fidelity}
    pitch = []
    for fraction in (1e-4, 0.2):
        inputs = {**push(packages, fraction), "operating_speed": speed}
        pitch.append(fly_alone(packages.plant, 10.0, 0.05, values, lambda _, inputs=inputs: inputs)["pitch"])
    return pitch[0], pitch[1]


def test_lpv_model_is_the_tangent(squid: Packages) -> None:
    """Near the trim both fidelities respond alike; far from it they do not.

    A deviation of size d has a curvature effect of order d^2. The remainder for small d is the residual of the
    polynomial fit, below 1 % of A for order 2, so 2 % of the response is allowed.
    """
    small, large = small_and_large(squid, 1)
    small_lpv, large_lpv = small_and_large(squid, LPV)
    travelled = np.ptp(small)
    assert 1e-7 < travelled < 1e-2
    assert np.max(np.abs((small - small[0]) - (small_lpv - small_lpv[0]))) < 0.02 * travelled
    assert np.max(np.abs((large - large[0]) - (large_lpv - large_lpv[0]))) > 0.1 * np.ptp(large)


def test_two_instances_do_not_touch_each_other(packages: Packages) -> None:
    """Two plants with different settings, stepped alternately, behave as each does alone."""
    commands = [push(packages, 0.02), push(packages, 0.1)]
    depths = [30.0, 45.0]
    alone = [
        fly_alone(packages.plant, 5.0, 0.05, {"initial_depth": depth}, lambda _, mine=mine: mine)
        for depth, mine in zip(depths, commands, strict=True)
    ]
    with Slave(packages.plant, "one") as one, Slave(packages.plant, "two") as two:
        for slave, depth in zip((one, two), depths, strict=True):
            slave.begin({"initial_depth": depth})
            slave.ready()
        for k in range(1, 101):
            for slave, mine in zip((one, two), commands, strict=True):
                for name, value in mine.items():
                    slave.set(name, value)
                slave.step_to(k * 0.05)
        ends = [{name: slave.get(name) for name in slave.names("output")} for slave in (one, two)]
    for end, expected in zip(ends, alone, strict=True):
        assert all(value == pytest.approx(expected[name][-1], abs=1e-9) for name, value in end.items())
    assert ends[0]["pitch"] != pytest.approx(ends[1]["pitch"], abs=1e-4)


def test_current_carries_the_vehicle_along(squid: Packages) -> None:
    """A constant current only moves the vehicle over ground."""
    commands = push(squid, 0.0)
    still = fly_alone(squid.plant, 20.0, 0.05, inputs=lambda _: commands)
    with Slave(squid.plant, "carried") as plant:
        plant.begin({"current_horizontal": 0.4})
        plant.ready()
        for name, value in commands.items():
            plant.set(name, value)
        for k in range(1, 401):
            plant.step_to(k * 0.05)
        assert plant.get("speed") == pytest.approx(still["speed"][-1], abs=1e-9)
        assert plant.get("distance") == pytest.approx(still["distance"][-1] + 0.4 * 20.0, abs=1e-6)


def test_reset_starts_again(packages: Packages) -> None:
    commands = push(packages, 0.1)
    with Slave(packages.plant, "again") as plant:
        ends = []
        for _ in range(2):
            plant.begin()
            plant.ready()
            for name, value in commands.items():
                plant.set(name, value)
            for k in range(1, 21):
                plant.step_to(k * 0.1)
            ends.append([plant.get(name) for name in plant.names("output")])
            plant.fmu.reset()
            plant.time = 0.0
        plant.begin()
        plant.ready()
    assert ends[0] == ends[1]
