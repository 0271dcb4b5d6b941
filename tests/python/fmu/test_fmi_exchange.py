"""Model exchange: FMPy's solver simulates plant and loop as the FMUs themselves do, within its tolerance."""

from __future__ import annotations

import ctypes
from pathlib import Path

import numpy as np
import pytest
from flights import limits
from fly.package import Packages
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.fmi2 import FMU2Model
from numpy.typing import NDArray

pytestmark = pytest.mark.change

MOTION = (
    "pitch",
    "pitch_rate",
    "speed",
    "heave",
    "depth",
    "distance",
    "heading",
    "roll",
    "sway",
    "north",
    "east",
)


def flown(fmu: Path, kind: str, stop_time: float = 10.0, **options: object) -> NDArray[np.void]:
    """Simulate ten seconds or more; of the two rows at an event the one before it is kept, as in co-simulation."""
    names = {v.name for v in read_model_description(fmu).modelVariables}
    motion = [name for name in MOTION if name in names]
    rows = simulate_fmu(
        fmu, fmi_type=kind, output=motion, stop_time=stop_time, output_interval=0.02, **options
    )
    _, first = np.unique(rows["time"].round(9), return_index=True)
    return rows[first]


def largest_difference(one: NDArray[np.void], other: NDArray[np.void]) -> float:
    assert np.allclose(one["time"], other["time"], atol=1e-9)
    names = [name for name in one.dtype.names if name != "time"]
    return max(np.max(np.abs(one[name] - other[name]) / (1.0 + np.abs(other[name]))) for name in names)


def pushed(packages: Packages) -> dict[str, float]:
    """Return commands well off the trim."""
    return {name: low + 0.7 * (high - low) for name, (low, high) in limits(packages).items()}


@pytest.mark.parametrize("fidelity", [1, 2])
def test_plant_agrees_to_the_tolerance_of_the_solver(packages: Packages, fidelity: int) -> None:
    agrees(packages, {"fidelity": fidelity, "current_horizontal": 0.3, "current_vertical": -0.1})


def test_so_it_does_in_six_degrees_of_freedom(turning: Packages) -> None:
    agrees(turning, {"current_north": 0.3, "current_east": -0.4, "current_vertical": -0.1})


def agrees(packages: Packages, water: dict[str, float]) -> None:
    start = {**pushed(packages), **water}
    stepped = flown(packages.plant, "CoSimulation", start_values=start)
    errors = []
    for tolerance in (1e-4, 1e-9):
        integrated = flown(
            packages.plant,
            "ModelExchange",
            start_values=start,
            solver="CVode",
            relative_tolerance=tolerance,
        )
        errors.append(largest_difference(integrated, stepped))
    assert np.ptp(stepped["pitch"]) > 0.01
    assert errors[1] < 1e-6
    assert errors[1] < errors[0] < 0.05


def test_solvers_look_beyond_the_stop_time(squid: Packages, monkeypatch: pytest.MonkeyPatch) -> None:
    """CVode evaluates beyond the stop time, so `fmi2SetTime` accepts such times; the result ends at the stop time."""
    asked = []
    take = FMU2Model.setTime

    def set_time(model: FMU2Model, time: float) -> None:
        asked.append(time)
        take(model, time)

    monkeypatch.setattr(FMU2Model, "setTime", set_time)
    rows = flown(squid.plant, "ModelExchange", solver="CVode", start_values=pushed(squid))
    assert rows["time"][-1] == pytest.approx(10.0)
    assert max(asked) > 10.0 + 1e-3


def test_loop_ticks_as_time_events(all_packages: Packages) -> None:
    stepped = flown(all_packages.loop, "CoSimulation", 25.0)
    integrated = flown(all_packages.loop, "ModelExchange", 25.0, solver="CVode", relative_tolerance=1e-9)
    assert np.ptp(stepped["pitch"]) > 0.01
    assert largest_difference(integrated, stepped) < 1e-6


def test_a_current_that_comes_suddenly_is_no_jump_of_a_state(squid: Packages) -> None:
    """The velocity over ground is the state, so that an input may jump without an event."""
    signals = np.array(
        [(0.0, 0.0), (2.0, 0.0), (2.0, 0.5), (10.0, 0.5)],
        dtype=[("time", np.float64), ("current_horizontal", np.float64)],
    )
    rows = simulate_fmu(
        squid.plant,
        fmi_type="ModelExchange",
        solver="CVode",
        relative_tolerance=1e-9,
        input=signals,
        output=["speed", "surge_over_ground", "pitch"],
        stop_time=4.0,
        output_interval=0.01,
    )
    around = np.searchsorted(rows["time"], [1.995, 2.015])
    before, after = rows[around[0]], rows[around[1]]
    assert after["speed"] - before["speed"] == pytest.approx(-0.5 * np.cos(after["pitch"]), abs=0.02)
    assert after["surge_over_ground"] == pytest.approx(before["surge_over_ground"], abs=0.02)


def test_states_and_rates_are_those_of_the_variables(squid: Packages, tmp_path: Path) -> None:
    """fmi2GetDerivatives and fmi2GetReal of the derivatives agree, in the order of ModelStructure."""
    folder = extract(squid.plant, tmp_path)
    description = read_model_description(folder)
    fmu = FMU2Model(
        guid=description.guid,
        unzipDirectory=folder,
        modelIdentifier=description.modelExchange.modelIdentifier,
        instanceName="plant",
    )
    fmu.instantiate()
    fmu.setupExperiment()
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    assert fmu.newDiscreteStates()[0] is False
    fmu.enterContinuousTimeMode()
    derivatives = [unknown.variable for unknown in description.derivatives]
    states = [variable.derivative for variable in derivatives]
    count = len(states)
    x, dx, nominals = (np.zeros(count) for _ in range(3))
    as_pointer = ctypes.POINTER(ctypes.c_double)
    fmu.getContinuousStates(x.ctypes.data_as(as_pointer), count)
    fmu.getDerivatives(dx.ctypes.data_as(as_pointer), count)
    fmu.getNominalsOfContinuousStates(nominals.ctypes.data_as(as_pointer), count)
    assert fmu.getReal([variable.valueReference for variable in states]) == x.tolist()
    assert fmu.getReal([variable.valueReference for variable in derivatives]) == dx.tolist()
    assert nominals.tolist() == [float(variable.nominal) for variable in states]
    fmu.terminate()
    fmu.freeInstance()
