"""Saved states, directional derivatives and unusual steps, through the C ABI of the packaged FMUs."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import masked
from fly.master import Slave
from fly.package import Packages
from fmpy.fmi1 import FMICallException
from syrupy.assertion import SnapshotAssertion

pytestmark = pytest.mark.change

KINDS = ("plant", "controller", "loop")
MOVED = {"plant": "current_vertical", "controller": "pitch_reference", "loop": "current_vertical"}
MOST = {"plant": 0.06, "controller": 1.0, "loop": 0.06}
"""The largest value of what moves (m/s, rad): a reference beyond the envelope."""


def ready(packages: Packages, kind: str, name: str = "one") -> Slave:
    """Return an instance that has run for a while."""
    slave = Slave(getattr(packages, kind), name)
    slave.begin()
    slave.ready()
    return slave


def outputs(slave: Slave) -> dict[str, float]:
    """Return every output, including status and limits."""
    kinds = ("Real", "Boolean", "Enumeration")
    return {name: slave.get(name) for kind in kinds for name in slave.names("output", kind)}


def fly_on(slave: Slave, kind: str, begin: float) -> list[float]:
    """Simulate half a second with a changing input; return every output after every step."""
    values = []
    for step in range(25):
        slave.set(MOVED[kind], MOST[kind] * ((step + 2) % 7) / 6.0)
        slave.fmu.doStep(begin + 0.02 * step, 0.02)
        values += [slave.get(name) for name in slave.names("output")]
    return values


@pytest.mark.parametrize("kind", KINDS)
def test_a_state_goes_on_to_the_bit(packages: Packages, kind: str) -> None:
    with ready(packages, kind) as first, ready(packages, kind, "two") as second:
        fly_on(first, kind, 0.0)
        shown = outputs(first)
        assert kind != "controller" or shown["reference_limited"] == 1.0
        state = first.fmu.getFMUstate()
        stored = first.fmu.serializeFMUstate(state)
        expected = fly_on(first, kind, 0.5)
        first.fmu.setFMUstate(state)
        assert outputs(first) == shown
        assert fly_on(first, kind, 0.5) == expected
        read = second.fmu.deSerializeFMUstate(stored)
        second.fmu.setFMUstate(read)
        assert outputs(second) == shown
        assert fly_on(second, kind, 0.5) == expected
        first.fmu.freeFMUstate(state)
        second.fmu.freeFMUstate(read)


@pytest.mark.parametrize("kind", KINDS)
def test_a_foreign_or_damaged_state_is_refused(
    squid: Packages,
    remus100: Packages,
    capsys: pytest.CaptureFixture[str],
    kind: str,
    snapshot: SnapshotAssertion,
) -> None:
    """The message states what is wrong with the bytes, and the instance continues."""
    with ready(squid, kind) as first, ready(remus100, kind) as other:
        state = first.fmu.getFMUstate()
        stored = first.fmu.serializeFMUstate(state)
        first.fmu.freeFMUstate(state)
        damaged = bytes([*stored[:-40], stored[-40] ^ 1, *stored[-39:]])
        capsys.readouterr()
        for slave, content in (
            (other, stored),
            (first, damaged),
            (first, stored[:-1]),
            (first, stored[:5]),
            (first, bytes(len(stored))),
        ):
            with pytest.raises(FMICallException):
                slave.fmu.deSerializeFMUstate(content)
        assert masked(capsys.readouterr().out) == snapshot
        fly_on(first, kind, 0.0)


def test_the_plants_derivatives_are_those_of_its_motion(packages: Packages) -> None:
    """Columns of the Jacobian at trim, compared with finite differences of the derivatives."""
    with ready(packages, "plant") as plant:
        reference = {name: variable.valueReference for name, variable in plant.variables.items()}
        rates = [f"der({name})" for name in ("surge_over_ground", "heave_over_ground", "pitch_rate", "pitch")]
        unknowns = [reference[name] for name in rates]
        actuator = plant.names("input")[0]
        exact = plant.fmu.getDirectionalDerivative(unknowns, [reference["current_horizontal"]], [1.0])
        step = 1e-5
        around = []
        for sign in (1.0, -1.0):
            plant.set("current_horizontal", sign * step)
            around.append(np.array(plant.fmu.getReal(unknowns)))
        difference = (around[0] - around[1]) / (2.0 * step)
        assert np.allclose(exact, difference, atol=1e-6)
        assert np.any(np.abs(exact) > 1e-3)
        lagged = plant.fmu.getDirectionalDerivative(
            [reference[f"der({actuator}_output)"]], [reference[actuator]], [1.0]
        )
        assert lagged[0] > 0.0


def test_the_controllers_derivatives_are_those_of_its_first_commands(packages: Packages) -> None:
    with Slave(packages.controller, "one") as controller:
        controller.begin()
        reference = {name: variable.valueReference for name, variable in controller.variables.items()}
        outputs = [name for name in controller.names("output") if name != "speed_out_of_range"]
        unknowns = [reference[name] for name in outputs]
        start = controller.get("pitch")
        exact = controller.fmu.getDirectionalDerivative(unknowns, [reference["pitch"]], [1.0])
        step = 1e-6
        around = []
        for sign in (1.0, -1.0):
            controller.set("pitch", start + sign * step)
            around.append(np.array(controller.fmu.getReal(unknowns)))
        difference = (around[0] - around[1]) / (2.0 * step)
        assert np.allclose(exact, difference, rtol=1e-6, atol=1e-6)
        assert np.any(np.abs(exact) > 1e-3)
        controller.ready()


@pytest.mark.parametrize("kind", ["plant", "loop"])
def test_an_input_on_a_ramp_is_the_limit_of_stairs(squid: Packages, kind: str) -> None:
    """One step of a second with the rate of the current, compared with a thousand steps of held current."""
    rate, pieces = 0.2, 1000
    with ready(squid, kind) as ramp, ready(squid, kind, "two") as stairs:
        reference = ramp.variables["current_vertical"].valueReference
        ramp.fmu.setRealInputDerivatives([reference], [1], [rate])
        ramp.fmu.doStep(0.0, 1.0)
        for piece in range(pieces):
            stairs.set("current_vertical", rate * (piece + 0.5) / pieces)
            stairs.fmu.doStep(piece / pieces, 1.0 / pieces)
        for name in ("pitch", "depth", "distance", "pitch_rate"):
            assert ramp.get(name) == pytest.approx(stairs.get(name), rel=1e-4, abs=1e-5), name
        assert ramp.get("current_vertical") == pytest.approx(rate, rel=1e-12)


@pytest.mark.parametrize("kind", ["plant", "loop"])
def test_outputs_move_as_their_derivatives_say(packages: Packages, kind: str) -> None:
    with ready(packages, kind) as slave:
        fly_on(slave, kind, 0.0)
        names = ["pitch", "pitch_rate", "speed", "heave", "path_speed", "depth", "distance"]
        references = [slave.variables[name].valueReference for name in names]
        stated = slave.fmu.getRealOutputDerivatives(references, [1] * len(names))
        before, step = np.array(slave.fmu.getReal(references)), 1e-6
        slave.fmu.doStep(0.5, step)
        found = (np.array(slave.fmu.getReal(references)) - before) / step
        assert np.allclose(stated, found, rtol=1e-3, atol=1e-4)
        assert np.all(np.abs(stated) > 0.0)


NEARLY_A_HUNDREDTH = (0.01, 0.00999999999999934, 0.010000000000000009)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("size", [*NEARLY_A_HUNDREDTH, 0.01 / 3.0, 1.0 / 7.0, 5.0])
def test_steps_of_any_size_fly_alike(squid: Packages, kind: str, size: float) -> None:
    """Ten seconds in steps as importers send them, compared with one step of ten seconds."""
    end = 10.0
    with ready(squid, kind) as cut, ready(squid, kind, "two") as whole:
        for slave in (cut, whole):
            slave.set(MOVED[kind], 0.05)
        nominal = 0.01 if size in NEARLY_A_HUNDREDTH else size
        count = round(end / nominal)
        for step in range(count):
            begin = step * nominal
            cut.fmu.doStep(begin, size if step + 1 < count else end - begin)
        whole.fmu.doStep(0.0, end)
        for name in cut.names("output"):
            assert cut.get(name) == pytest.approx(whole.get(name), rel=1e-9, abs=1e-9), name


def test_many_steps_of_a_microsecond(squid: Packages) -> None:
    with ready(squid, "loop") as cut, ready(squid, "loop", "two") as whole:
        for step in range(50_000):
            cut.fmu.doStep(step * 1e-6, 1e-6)
        whole.fmu.doStep(0.0, 0.05)
        for name in cut.names("output"):
            assert cut.get(name) == pytest.approx(whole.get(name), rel=1e-9, abs=1e-9), name
