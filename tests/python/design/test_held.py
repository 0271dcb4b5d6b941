"""A disturbance that saturates the planes and keeps them saturated: REMUS 100 in a current, with its FMUs.

When references did not yield, the depth autopilot lost speed, and with it the force of the planes: in a downward
current of 0.4 m/s REMUS 100 sank from 20 to 44 m, at half its speed, and stayed there after the current.
"""

from __future__ import annotations

import numpy as np
import pytest
from conftest import REMUS100, Run, kept
from flights import sample_time
from fly.master import Signals, Slave, couple
from fly.package import Packages

pytestmark = pytest.mark.change

DEPTH = 20.0
BEGIN, END, DURATION = 10.0, 100.0, 165.0
"""When the current begins and ends, and the flight (s)."""
BACK = 40.0
"""In what time after its end the depth is there again (s)."""
CASES = [(1.4, 0.35), (1.4, 0.4), (1.5, 0.5), (1.7, 0.9), (2.1, 1.0)]
"""Speed and current (m/s)."""


@pytest.fixture(scope="module")
def deep(run_squid: Run) -> Packages:
    return kept(run_squid, REMUS100, "--axis", "depth")


def fly(packages: Packages, speed: float, current: float, duration: float = DURATION) -> Signals:
    """Hold a depth in a downward current."""
    saturated: list[tuple[float, float]] = []
    with (
        Slave(packages.plant, "plant", quiet=True) as plant,
        Slave(packages.controller, "controller", quiet=True) as controller,
    ):
        plant.begin({"initial_speed": speed, "initial_depth": DEPTH})
        controller.begin()
        forward = plant.get("speed")

        def references(_: int, time: float) -> dict[str, float]:
            plant.set("current_vertical", current if BEGIN <= time < END else 0.0)
            saturated.append((controller.get("stern_planes_saturated"), controller.get("propeller")))
            return {"depth_reference": DEPTH, "speed_reference": forward}

        flown = couple(plant, controller, references, duration, sample_time(packages))
    says, thrust = np.array(saturated).T
    return {**flown, "saturated": says, "thrust": thrust}


@pytest.mark.parametrize(("speed", "current"), CASES)
def test_the_speed_is_kept_and_the_depth_comes_back(deep: Packages, speed: float, current: float) -> None:
    flown = fly(deep, speed, current)
    time, asked = flown["time"], flown["speed"][0]
    acting = (time > BEGIN) & (time <= END)
    assert flown["speed"][acting].min() > 0.9 * asked
    assert flown["depth"].max() < DEPTH + 6.0
    assert np.abs(flown["depth"][time > END + BACK] - DEPTH).max() < 0.02
    # The planes stay saturated, and the propeller does not brake meanwhile.
    held = flown["saturated"] > 0.0
    assert np.count_nonzero(held) * sample_time(deep) > 1.0
    assert flown["thrust"][held].min() >= 0.0 and not held[-1]
    assert flown["depth_reference_used"][-1] == DEPTH


def test_a_state_in_the_middle_of_it_has_every_output(deep: Packages) -> None:
    """Saved while a reference yields and restored in another instance: all outputs agree before a step."""
    with (
        Slave(deep.controller, "one", quiet=True) as one,
        Slave(deep.controller, "other", quiet=True) as other,
    ):
        for controller in (one, other):
            controller.begin({"depth": DEPTH, "speed": 1.6, "depth_reference": DEPTH, "speed_reference": 1.6})
            controller.ready()
        step = sample_time(deep)
        for tick in range(1, 150):
            one.set("depth", DEPTH + min(0.02 * tick, 3.0))
            one.step_to(tick * step)
        assert one.get("stern_planes_saturated") and one.get("depth_reference_used") > DEPTH + 1.0
        state = one.fmu.getFMUstate()
        saved = one.fmu.serializeFMUstate(state)
        one.fmu.freeFMUstate(state)
        state = other.fmu.deSerializeFMUstate(saved)
        other.fmu.setFMUstate(state)
        other.fmu.freeFMUstate(state)
        outputs = [v.name for v in one.description.modelVariables if v.causality == "output"]
        assert {name: one.get(name) for name in outputs} == {name: other.get(name) for name in outputs}
