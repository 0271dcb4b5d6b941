"""Simulations of the FMUs that several tests share."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from conftest import Run
from fly.master import Signals, Slave, couple
from fly.package import Packages
from fmpy import read_model_description

TEN_DEGREES = float(np.deg2rad(10.0))
STEP_TIME = 5.0


def figures_of(run_squid: Run, flown: Signals, folder: Path) -> dict:
    """Return the figures that `squid plot --json` computes for a record."""
    record = folder / "flown.csv"
    columns = np.column_stack([*flown.values()])
    np.savetxt(record, columns, fmt="%.17g", delimiter=",", header=",".join(flown), comments="")
    done = run_squid("plot", record, "--json")
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def turns(packages: Packages) -> bool:
    """Return True if the vehicle moves in six degrees of freedom."""
    return any(v.name == "heading" for v in read_model_description(packages.plant).modelVariables)


def place(packages: Packages) -> tuple[str, ...]:
    """Return the outputs for the position of the vehicle."""
    return ("depth", "north", "east", "heading") if turns(packages) else ("depth", "distance")


def start_value(fmu: Path, name: str) -> float:
    """Return the start value of a variable in the model description."""
    variables = read_model_description(fmu).modelVariables
    return next(float(variable.start) for variable in variables if variable.name == name)


def sample_time(packages: Packages) -> float:
    """Return the sample time of the autopilot (s)."""
    return start_value(packages.controller, "sample_time")


def engagement(packages: Packages) -> set[str]:
    """Return the inputs of the controller for applied commands, engagement, and validity of sensors."""
    inputs = [
        v.name for v in read_model_description(packages.controller).modelVariables if v.causality == "input"
    ]
    valid = (f"{name}_valid" for name in inputs if f"{name}_valid" in inputs)
    return {"engaged", "applied_given", *(f"{name}_applied" for name in limits(packages)), *valid}


def limits(packages: Packages) -> dict[str, tuple[float, float]]:
    """Return the limits of each actuator, as the plant's inputs state them."""
    plant = {
        v.name: v for v in read_model_description(packages.plant).modelVariables if v.causality == "input"
    }
    outputs = [
        v.name for v in read_model_description(packages.controller).modelVariables if v.causality == "output"
    ]
    return {name: (float(plant[name].min), float(plant[name].max)) for name in outputs if name in plant}


def pitch_step(packages: Packages, speed: float, height: float, duration: float, **values: float) -> Signals:
    """Simulate a permanent pitch step (rad) from trim at a constant speed (m/s), plant and controller coupled."""
    flown, start = _step(packages, speed, {"pitch": height}, duration, **values)
    flown["pitch_done"] = (flown["pitch"] - start["pitch"]) / height
    flown["speed_error"] = flown["speed"] - start["speed"]
    return flown


def speed_step(packages: Packages, speed: float, height: float, duration: float) -> Signals:
    """Simulate a permanent speed step (m/s) from trim at a speed (m/s), plant and controller coupled."""
    flown, start = _step(packages, speed, {"speed": height}, duration)
    flown["speed_done"] = (flown["speed"] - start["speed"]) / height
    return flown


def _step(
    packages: Packages, speed: float, heights: Mapping[str, float], duration: float, **values: float
) -> tuple[Signals, dict[str, float]]:
    with Slave(packages.plant, "plant") as plant, Slave(packages.controller, "controller") as controller:
        plant.begin({"initial_speed": speed, **values})
        controller.begin()
        start = {"pitch": plant.get("trim_pitch"), "speed": plant.get("speed"), "depth": plant.get("depth")}
        end = {name: value + heights.get(name, 0.0) for name, value in start.items()}

        def references(_: int, time: float) -> dict[str, float]:
            now = end if time >= STEP_TIME else start
            return {f"{name}_reference": value for name, value in now.items()}

        return couple(plant, controller, references, duration, sample_time(packages)), start


def fly_alone(
    fmu: Path,
    duration: float,
    step: float,
    values: Mapping[str, float] | None = None,
    inputs: Callable[[float], Mapping[str, float]] | None = None,
) -> Signals:
    """Simulate one FMU from its own start with a communication step (s) and inputs over time, exactly to the end."""
    with Slave(fmu, "alone") as slave:
        slave.begin(values)
        slave.ready()
        names = slave.names("output")
        references = slave.references(names)
        rows = [[0.0, *slave.fmu.getReal(references)]]
        count = 0
        while slave.time < duration - 1e-9:
            for name, value in (inputs(slave.time) if inputs else {}).items():
                slave.set(name, value)
            count += 1
            slave.step_to(min(count * step, duration))
            rows.append([slave.time, *slave.fmu.getReal(references)])
    return dict(zip(["time", *names], np.array(rows).T, strict=True))
