"""The autopilot in C controls the vehicle: as the FMU in double, nearly so in float; missed ticks and wrong inputs."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from conftest import Run
from embedded import Exported, Shell
from flights import fly_alone, limits, sample_time
from fly import flight
from fly.master import Signals, Slave
from fly.package import Packages
from fmpy import read_model_description
from fmpy.fmi1 import FMICallException

pytestmark = pytest.mark.change

BAD_INPUT = 1
LARGEST_ERROR = {"commands": 2e-5, "rad": 1e-5, "m/s": 5e-5}
"""Of float over the default flights, as docs/embedding.md states it: of the range of an actuator; pitch; speed."""


@pytest.fixture
def flown_by_c(
    packages: Packages, loop: Signals, tmp_path: Path, run_squid: Run, monkeypatch: pytest.MonkeyPatch
):
    """Return a function that runs the coupled simulation with the source in place of the controller's FMU."""

    def fly(real: str) -> Signals:
        exported = Exported.of(run_squid, packages, tmp_path / real, "--real", real).without_noise()
        begin = Slave.begin

        def replaced(slave: Slave, values: Mapping[str, float] | None = None) -> None:
            if slave.description.modelName.endswith("controller"):
                slave.fmu.freeInstance()
                references = {name: one.valueReference for name, one in slave.variables.items()}
                slave.fmu = Shell(exported, references)
            begin(slave, values)

        with monkeypatch.context() as patch:
            patch.setattr(Slave, "begin", replaced)
            return flight.fly_coupled(packages, loop)

    return fly


@pytest.fixture
def loop(packages: Packages) -> Signals:
    """Return the default simulation of the closed-loop FMU."""
    end = float(read_model_description(packages.loop).defaultExperiment.stopTime)
    return fly_alone(packages.loop, end, sample_time(packages))


def test_double_is_the_fmu(packages: Packages, loop: Signals, flown_by_c) -> None:
    by_fmu, by_c = flight.fly_coupled(packages, loop), flown_by_c("double")
    assert by_fmu.keys() == by_c.keys()
    assert all(np.array_equal(by_fmu[name], by_c[name]) for name in by_fmu)


def test_float_is_nearly_the_same(packages: Packages, flown_by_c) -> None:
    double, float_ = flown_by_c("double"), flown_by_c("float")
    of = {name: np.abs(double[name] - float_[name]).max() for name in double}
    commands = max(of[name] / (high - low) for name, (low, high) in limits(packages).items())
    found = {"commands": commands, "rad": of["pitch"], "m/s": of["speed"]}
    print(found)
    assert all(0.0 < found[what] <= most for what, most in LARGEST_ERROR.items()), found


def test_missed_ticks_are_made_up_for_as_in_the_fmu(squid: Packages, run_squid: Run, tmp_path: Path) -> None:
    """Three overdue ticks with the newest inputs equal one FMU step of three samples; without them nothing runs."""
    exported, ts = Exported.of(run_squid, squid, tmp_path).without_noise(), sample_time(squid)
    with Slave(squid.controller, "controller") as fmu:
        c = Shell(exported, {name: one.valueReference for name, one in fmu.variables.items()})
        outputs = [fmu.variables[name].valueReference for name in c.outputs]
        fmu.begin()
        fmu.ready()
        c.taken[: len(c.inputs)] = [fmu.get(name) for name in c.inputs]
        c.exitInitializationMode()
        pitch = fmu.variables["pitch"].valueReference
        for start, ticks, value in ((0, 1, 0.01), (1, 3, -0.02), (4, 2, 0.05)):
            before = c.getReal(outputs)
            c.setReal([pitch], [value])
            assert c.getReal(outputs) == before, "the last commands hold until a tick runs"
            fmu.set("pitch", value)
            fmu.step_to((start + ticks) * ts)
            for _ in range(ticks):
                c.doStep()
            assert c.getReal(outputs) == fmu.fmu.getReal(outputs)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_a_reference_that_is_no_number_changes_nothing(
    squid: Packages, run_squid: Run, tmp_path: Path, value: float
) -> None:
    """Both refuse it, and continue as if it had not been set."""
    exported, ts = Exported.of(run_squid, squid, tmp_path).without_noise(), sample_time(squid)
    with Slave(squid.controller, "controller") as fmu:
        c = Shell(exported, {name: one.valueReference for name, one in fmu.variables.items()})
        outputs, inputs = fmu.references(c.outputs), fmu.references(c.inputs)
        fmu.begin()
        fmu.ready()
        good = [fmu.get(name) for name in c.inputs]
        c.setReal(inputs, good)
        c.exitInitializationMode()
        wanted = [place for place, name in enumerate(c.inputs) if name.endswith("_reference")]
        for step, place in enumerate(wanted):
            bad = [*good[:place], value, *good[place + 1 :]]
            c.setReal(inputs, bad)
            state, given = bytes(c.state), bytes(c.given)
            assert c.library[f"{c.name}_step"](c.state, c.taken, c.given) == BAD_INPUT
            assert (bytes(c.state), bytes(c.given)) == (state, given)
            with pytest.raises(FMICallException):
                fmu.fmu.setReal(inputs, bad)
            good[place] += 0.01
            c.setReal(inputs, good)
            fmu.fmu.setReal(inputs, good)
            fmu.step_to((step + 1) * ts)
            c.doStep()
            assert c.getReal(outputs) == fmu.fmu.getReal(outputs)
