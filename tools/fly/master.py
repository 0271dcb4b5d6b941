"""A small co-simulation master, which exchanges the signals of plant and controller and steps them in turn.

At each sample the controller reads the current outputs of the plant, and its commands act during the step that follows,
without a sample of delay, as in the closed-loop FMU.
"""

from __future__ import annotations

import json
import shutil
from bisect import bisect_right
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import TracebackType

import numpy as np
from fmpy import extract, fmi2, read_model_description
from fmpy.fmi2 import FMU2Slave
from numpy.typing import NDArray

Signals = dict[str, NDArray[np.float64]]
References = Callable[[int, float], Mapping[str, float]]
"""Number of the sample and time (s) to the references (SI) by the names of the controller's inputs."""


class Slave:
    """An instance of an FMU with access to variables by name, used as a context manager.

    Its messages are printed unless it is quiet.
    """

    def __init__(self, fmu: Path, name: str, quiet: bool = False) -> None:
        self.folder = Path(extract(fmu))
        self.description = read_model_description(self.folder)
        self.variables = {variable.name: variable for variable in self.description.modelVariables}
        identifier = self.description.coSimulation.modelIdentifier
        self.fmu = FMU2Slave(
            guid=self.description.guid,
            unzipDirectory=str(self.folder),
            modelIdentifier=identifier,
            instanceName=name,
        )
        self.fmu.instantiate(callbacks=unheard() if quiet else None)
        self.time = 0.0

    def __enter__(self) -> Slave:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is None:
            self.fmu.terminate()
        self.fmu.freeInstance()
        shutil.rmtree(self.folder, ignore_errors=True)

    def names(self, causality: str, kind: str = "Real") -> list[str]:
        """Return the names of the variables of a causality and a type, in the order of the model description."""
        return [
            v.name for v in self.description.modelVariables if v.causality == causality and v.type == kind
        ]

    def start_values(self) -> dict[str, float]:
        """Return the start values of all parameters in the model description."""
        parameters = [v for v in self.description.modelVariables if v.causality == "parameter"]
        return {v.name: float(v.start) for v in parameters if v.type in ("Real", "Enumeration")}

    def begin(self, values: Mapping[str, float] | None = None) -> None:
        """Set parameters and enter initialization mode."""
        self.fmu.setupExperiment(startTime=0.0)
        for name, value in (values or {}).items():
            self.set(name, value)
        self.fmu.enterInitializationMode()

    def ready(self) -> None:
        """Exit initialization mode."""
        self.fmu.exitInitializationMode()

    def set(self, name: str, value: float) -> None:
        """Set one variable of any type."""
        variable = self.variables[name]
        references = [variable.valueReference]
        if variable.type == "Real":
            self.fmu.setReal(references, [value])
        elif variable.type == "Boolean":
            self.fmu.setBoolean(references, [bool(value)])
        else:
            self.fmu.setInteger(references, [int(value)])

    def get(self, name: str) -> float:
        """Return one variable of any type."""
        variable = self.variables[name]
        references = [variable.valueReference]
        if variable.type == "Real":
            return self.fmu.getReal(references)[0]
        if variable.type == "Boolean":
            return float(self.fmu.getBoolean(references)[0])
        return float(self.fmu.getInteger(references)[0])

    def limits(self, name: str) -> tuple[float, float]:
        """Return the minimum and the maximum of a variable."""
        variable = self.variables[name]
        return float(variable.min), float(variable.max)

    def references(self, names: Sequence[str]) -> list[int]:
        """Return the value references of variables."""
        return [self.variables[name].valueReference for name in names]

    def step_to(self, time: float) -> None:
        """Step to a time (s)."""
        self.fmu.doStep(currentCommunicationPoint=self.time, communicationStepSize=time - self.time)
        self.time = time


def unheard() -> fmi2.fmi2CallbackFunctions:
    """Return callbacks that print nothing."""
    callbacks = fmi2.fmi2CallbackFunctions.from_buffer_copy(fmi2.defaultCallbacks)
    callbacks.logger = fmi2.fmi2CallbackLoggerTYPE(lambda *_: None)
    return callbacks


class Recorder:
    """Records all real outputs of slaves; for outputs with the same name, that of the first slave."""

    def __init__(self, *slaves: Slave) -> None:
        self.plan = []
        self.names = []
        for slave in slaves:
            names = [name for name in slave.names("output") if name not in self.names]
            self.names += names
            self.plan.append((slave.fmu, slave.references(names)))
        self.rows: list[list[float]] = []

    def sample(self, time: float) -> None:
        """Record one row."""
        row = [time]
        for fmu, references in self.plan:
            row += fmu.getReal(references)
        self.rows.append(row)

    def signals(self) -> Signals:
        """Return a column for each output, and `time`."""
        columns = np.array(self.rows).T
        return dict(zip(["time", *self.names], columns, strict=True))


def shared(source: Slave, sink: Slave) -> list[str]:
    """Return the names of the outputs of one slave that are inputs of the other."""
    inputs = set(sink.names("input"))
    return [name for name in source.names("output") if name in inputs]


def couple(
    plant: Slave, controller: Slave, references: References, duration: float, sample_time: float
) -> Signals:
    """Simulate plant and controller in one loop for a time (s), exchanging signals every `sample_time` (s).

    Both are in initialization mode (`Slave.begin`). `references` is called at each sample and acts from that sample.
    """
    loop = Loop(plant, controller)
    loop.inform(references(0, 0.0))
    # An actuator without lag follows the first command from the start.
    loop.command()
    plant.ready()
    controller.ready()
    recorder = Recorder(controller, plant)
    recorder.sample(0.0)
    for k in range(round(duration / sample_time)):
        loop.inform(references(k, k * sample_time))
        end = (k + 1) * sample_time
        controller.step_to(end)
        loop.command()
        plant.step_to(end)
        recorder.sample(end)
    return recorder.signals()


def path_speed_of(controller: Slave) -> Callable[[float], float]:
    """Return the map from forward speed u to the speed V along the path in level flight (m/s), both through the water.

    It interpolates linearly in the trim table in the controller's FMU, and extrapolates beyond its ends.
    """
    design = controller.folder / "resources" / "controller.json"
    trim = json.loads(design.read_text(encoding="utf-8"))["trim"]
    path, forward = trim["speed"], trim["forward_speed"]

    def path_speed(speed: float) -> float:
        row = min(max(bisect_right(forward, speed) - 1, 0), len(forward) - 2)
        part = (speed - forward[row]) / (forward[row + 1] - forward[row])
        return (1.0 - part) * path[row] + part * path[row + 1]

    return path_speed


class Loop:
    """The connections between plant and controller.

    The outputs of actuators with gains are these multiples of their commands, within their limits.
    """

    def __init__(self, plant: Slave, controller: Slave, gains: Mapping[str, float] | None = None) -> None:
        self.plant, self.controller = plant, controller
        actuators = shared(controller, plant)
        self.gains = [(gains[name], *plant.limits(name)) for name in actuators] if gains else None
        measured = shared(plant, controller)
        self.measured = plant.references(measured)
        self.given = "given_speed" in plant.variables
        self.wanted = [name for name in controller.names("input") if name.endswith("_reference")]
        self.heard = controller.references([*measured, *self.wanted])
        self.commands = controller.references(actuators)
        self.linear = "operating_speed" in plant.variables
        speeds = [name for name in ("operating_speed", "given_speed") if name in plant.variables]
        self.commanded = plant.references([*actuators, *speeds])
        self.path_speed = path_speed_of(controller)
        self.speed_reference = 0.0

    def inform(self, references: Mapping[str, float]) -> None:
        """Pass the plant's outputs and references to the controller; a prescribed speed is not one of them."""
        measured = self.plant.fmu.getReal(self.measured)
        self.controller.fmu.setReal(self.heard, [*measured, *(references[name] for name in self.wanted)])
        self.speed_reference = references["speed_reference"]

    def command(self) -> list[float]:
        """Pass the commands to the plant, and return them.

        An LPV plant is linearised about the trim of the reference speed. A plant with prescribed speed receives the
        reference.
        """
        commands = self.controller.fmu.getReal(self.commands)
        if self.gains:
            pairs = zip(commands, self.gains, strict=True)
            commands = [min(max(command * gain, low), high) for command, (gain, low, high) in pairs]
        given = [self.speed_reference] if self.given else []
        path_speed = [self.path_speed(self.speed_reference)] if self.linear else []
        self.plant.fmu.setReal(self.commanded, [*commands, *path_speed, *given])
        return commands
