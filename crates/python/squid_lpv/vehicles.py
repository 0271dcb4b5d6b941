"""Underwater vehicles: models, designs, simulations."""

from __future__ import annotations

import json
import shutil
import tempfile
import weakref
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from squid_lpv import _core, systems
from squid_lpv.certificates import Certificate
from squid_lpv.errors import InputError, NumericalError
from squid_lpv.synthesis import LpvController, Progress, lpv_controller
from squid_lpv.systems import StateSpace


@dataclass(frozen=True)
class Trim:
    """Level trim: V along the path (m/s), depth (m), pitch (rad), u and w (m/s), outputs of actuators (N, rad)."""

    speed: float
    depth: float
    pitch: float
    forward_speed: float
    heave: float
    actuators: dict[str, float]


@dataclass(frozen=True)
class Linearisation:
    """Deviations from a trim: `x' = A x + B u`, SI units; `states` and `inputs` name x and u."""

    trim: Trim
    states: list[str]
    inputs: list[str]
    A: np.ndarray
    B: np.ndarray

    def system(self) -> Any:
        """Return the model as a system whose outputs are its states."""
        n, m = self.B.shape
        return systems.given_back(StateSpace(self.A, self.B, np.eye(n), np.zeros((n, m))))


class Vehicle:
    """A vehicle with the requirements on its autopilot."""

    def __init__(self, core: _core.Vehicle) -> None:
        """Use `Vehicle.read` or `Vehicle.of`."""
        self._core = core

    @classmethod
    def read(cls, directory: str | Path, design: str = "design", axis: str | None = None) -> Vehicle:
        """Read `vehicle.toml` and a design file of a directory, as `squid new` writes them.

        Args:
            directory: the directory of the files.
            design: the name of the design file, without `.toml`.
            axis: the axis of a file with several, by the quantity it controls: pitch, depth or heading.

        Raises:
            InputError: a file is invalid; the message gives file, line and key.

        """
        return cls(_core.Vehicle.read(str(directory), design, axis))

    @classmethod
    def of(cls, vehicle: str, design: str) -> Vehicle:
        """Return a vehicle from the texts of both files."""
        return cls(_core.Vehicle.of(vehicle, design))

    @property
    def name(self) -> str:
        """Name of the vehicle."""
        return self._core.name

    @property
    def axis(self) -> str:
        """Quantity that the axis controls, which is also the name of the axis."""
        return self._core.axis

    @property
    def actuators(self) -> list[str]:
        """Names of the actuators."""
        return self._core.actuators

    @property
    def speeds(self) -> tuple[float, float]:
        """Range of speed of the design, m/s along the path."""
        return self._core.speeds

    def linearise(self, speed: float) -> Linearisation:
        """Return trim and linear model at a speed along the path, m/s.

        Raises:
            InputError: there is no trim at that speed.

        """
        found = json.loads(self._core.at_speed(float(speed)))
        a, b = np.array(found["A"]), np.array(found["B"])
        return Linearisation(Trim(**found["trim"]), found["states"], self.actuators, a, b)

    def design(
        self, directory: str | Path | None = None, *, robust: bool = False, progress: Progress | None = None
    ) -> Design:
        """Design an autopilot, and return it with its proofs; this takes about half a minute.

        Args:
            directory: the directory for its files, as of `squid design --out`; `None` for a temporary directory,
                which exists as long as the object.
            robust: design for the declared uncertainty.
            progress: a function called with progress reports.

        Raises:
            InfeasibleError: there is no controller.
            NumericalError: no controller was found.

        """
        folder = Path(tempfile.mkdtemp(prefix="squid-") if directory is None else directory)
        design = Design(self, folder)
        if directory is None:
            weakref.finalize(design, shutil.rmtree, folder, ignore_errors=True)
        self._core.design(str(folder), robust, progress)
        return design


@dataclass(frozen=True)
class Flight:
    """Record: `columns` by name, SI units in `units`, 1 for none; `surfacing` describes an end at the surface."""

    columns: dict[str, np.ndarray]
    units: dict[str, str]
    surfacing: str | None

    def __getitem__(self, name: str) -> np.ndarray:
        """Return a column."""
        return self.columns[name]


@dataclass(frozen=True)
class Design:
    """Finished design in a directory, with files that the command line also reads."""

    vehicle: Vehicle
    directory: Path

    @classmethod
    def read(cls, vehicle: Vehicle, directory: str | Path) -> Design:
        """Return the design in a directory.

        Raises:
            InputError: the directory contains no design.

        """
        if not (Path(directory) / "controller.json").is_file():
            raise InputError(f"{directory} has no controller.json; Vehicle.design makes one")
        return cls(vehicle, Path(directory))

    def _json(self, name: str) -> dict[str, Any]:
        return json.loads((self.directory / name).read_text(encoding="utf-8"))

    @property
    def figures(self) -> dict[str, Any]:
        """Figures of `design.json`: gammas, checks, verdict."""
        return self._json("design.json")

    @property
    def gamma(self) -> float:
        """Proved bound on the gain of the loop; `certificate.verify()` proves it again."""
        return self.figures["gamma_bound"]

    @property
    def verdict(self) -> list[dict[str, Any]]:
        """Requirements, and the achieved figures of the simulated loop."""
        return self.figures["verdict"]["rows"]

    @property
    def certificate(self) -> Certificate:
        """Proof of the gain.

        Raises:
            NumericalError: the gain is not proved; the figures give the reason.

        """
        path = self.directory / "certificate.json"
        if not path.is_file():
            raise NumericalError(f"the design is not proved: {self.figures['not_certified_because']}")
        return Certificate.read(path)

    @property
    def lft(self) -> LpvController:
        """Controller scheduled by rho, from -1 at the lowest to 1 at the highest speed."""
        return lpv_controller(self._json("controller.json")["lft"])

    def controller(self, speed: float) -> Any:
        """Return the controller at a constant speed, m/s along the path."""
        low, high = self.vehicle.speeds
        if not low <= speed <= high:
            raise InputError(f"speed is {speed} m/s; the design is for {low} to {high}")
        return self.lft.frozen(float(np.clip((2.0 * speed - low - high) / (high - low), -1.0, 1.0)))

    def simulate(self, manoeuvre: dict[str, float] | None = None, *, sea: str | None = None) -> Flight:
        """Simulate the nonlinear vehicle with the sampled autopilot.

        Args:
            manoeuvre: differences from the default, by the keys of `manoeuvre.json` and a key for each
                of its steps: pitch_step (rad), depth_step (m, if the depth is tracked), step_time,
                speed_from, speed_to, duration and so on.
            sea: the text of a sea file.

        Raises:
            InputError: the manoeuvre or the sea is invalid.
            NumericalError: the simulation failed.

        """
        text = None if manoeuvre is None else _changed(self._json("manoeuvre.json"), manoeuvre)
        return _flight(self.vehicle._core.simulate(str(self.directory), text, sea))

    def savemat(self, path: str | Path, speeds: Sequence[float]) -> None:
        """Write the frozen controller on a grid of speeds to a .mat file.

        After MATLAB's `load`, `ss(K.a(:,:,i), K.b(:,:,i), K.c(:,:,i), K.d(:,:,i))` is the controller at `speeds(i)`.
        """
        from scipy.io import savemat as write

        frozen = [systems.of(self.controller(speed)) for speed in speeds]
        stacked = {key.lower(): np.stack([getattr(k, key) for k in frozen], axis=2) for key in "ABCD"}
        write(path, {"K": stacked, "speeds": np.asarray(speeds, dtype=float), "gam": self.gamma})


@dataclass(frozen=True)
class Autopilot:
    """Designs of all axes of a design file for one vehicle, by the quantity that each axis controls."""

    axes: dict[str, Design]

    @classmethod
    def design(
        cls,
        vehicle: str | Path,
        design: str = "design",
        *,
        directory: str | Path,
        progress: Progress | None = None,
    ) -> Autopilot:
        """Design each axis of a design file, and return the designs with their proofs.

        Args:
            vehicle: the directory of `vehicle.toml` and the design file.
            design: the name of the design file, without `.toml`.
            directory: the directory for the files, with a folder for each axis by its name, as of
                `squid design --out`.
            progress: a function called with progress reports.

        Raises:
            InfeasibleError: there is no controller.
            NumericalError: no controller was found.

        """
        axes = cls._vehicles(vehicle, design)
        folders = cls._folders(axes, Path(directory))
        return cls({name: axes[name].design(folders[name], progress=progress) for name in axes})

    @classmethod
    def read(cls, vehicle: str | Path, directory: str | Path, design: str = "design") -> Autopilot:
        """Return the designs that `squid design` or `Autopilot.design` wrote to a directory.

        Raises:
            InputError: an axis has no design there.

        """
        axes = cls._vehicles(vehicle, design)
        folders = cls._folders(axes, Path(directory))
        return cls({name: Design.read(axes[name], folders[name]) for name in axes})

    @staticmethod
    def _vehicles(vehicle: str | Path, design: str) -> dict[str, Vehicle]:
        return {one.axis: Vehicle(one) for one in _core.Vehicle.axes(str(vehicle), design)}

    @staticmethod
    def _folders(axes: dict[str, Vehicle], directory: Path) -> dict[str, Path]:
        return {name: directory / name if len(axes) > 1 else directory for name in axes}

    def simulate(self, manoeuvre: dict[str, float] | None = None, *, sea: str | None = None) -> Flight:
        """Simulate all axes of the nonlinear vehicle in six degrees of freedom.

        Args:
            manoeuvre: differences from the default, as for `Design.simulate`, with the steps of all axes.
            sea: the text of a sea file.

        Raises:
            InputError: the manoeuvre or the sea is invalid.
            NumericalError: the simulation failed.

        """
        defaults = [axis._json("manoeuvre.json") for axis in self.axes.values()]
        steps = {name: height for one in defaults for name, height in one["steps"].items()}
        text = _changed(defaults[0] | {"steps": steps}, manoeuvre or {})
        axes = list(self.axes.values())
        cores, folders = [axis.vehicle._core for axis in axes], [str(axis.directory) for axis in axes]
        return _flight(_core.Vehicle.simulate_all(cores, folders, text, sea))


def _changed(default: dict[str, Any], manoeuvre: dict[str, float]) -> str:
    """Return the text of a manoeuvre with other values; a key NAME_step is the step of NAME."""

    def is_step(key: str) -> bool:
        return key.endswith("_step")

    given = {key: value for key, value in manoeuvre.items() if not is_step(key)}
    steps = {key.removesuffix("_step"): value for key, value in manoeuvre.items() if is_step(key)}
    return json.dumps(default | given | {"steps": default["steps"] | steps})


def _flight(flown: tuple[list[tuple[str, str, list[float]]], str | None]) -> Flight:
    """Return the record of a simulation."""
    columns, surfacing = flown
    values = {name: np.array(column) for name, _, column in columns}
    return Flight(values, {name: unit for name, unit, _ in columns}, surfacing)
