"""Code that runs on a worker, which need not have this package: Dask sends it."""

from __future__ import annotations

import io
import json
import os
import shutil
import subprocess
import tempfile
import zipfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from distributed import Worker, get_worker
from distributed.diagnostics.plugin import WorkerPlugin
from fly.master import Loop, Slave, shared
from fmpy.fmi1 import FMICallException
from numpy.typing import NDArray

PLANT, CONTROLLER = "plant.fmu", "controller.fmu"
WATCHED = ["pitch", "speed", "depth", "distance"]
"""Outputs of the plant in a record."""


class Files(WorkerPlugin):
    """The files of a campaign, in a folder on each present or future worker."""

    def __init__(self, name: str, files: dict[str, bytes]) -> None:
        self.name, self.files = name, files

    def setup(self, worker: Worker) -> None:
        """Write the files."""
        for name, content in self.files.items():
            path = Path(worker.local_directory, self.name, name)
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)

    def teardown(self, worker: Worker) -> None:
        """Remove the files."""
        shutil.rmtree(Path(worker.local_directory, self.name), ignore_errors=True)


def folder_of(name: str) -> Path:
    """Return the folder of the files of a campaign on this worker."""
    return Path(get_worker().local_directory, name)


def fly_by_command(name: str, command: Sequence[str], version: str, part: tuple[int, int]) -> bytes:
    """Simulate a part of a campaign with a version of the command `squid`, and return the file of its results."""
    folder = folder_of(name)
    found = printed([command[0], "--version"], folder)
    if found != version:
        raise RuntimeError(f"the worker has {found.strip()}, and {version.strip()} is needed")
    with tempfile.TemporaryDirectory(dir=folder) as to:
        printed([*command, "--only", "{}-{}".format(*part), "--to", to], folder)
        (results,) = Path(to).glob("*.parquet")
        return results.read_bytes()


def printed(words: Sequence[str], folder: Path) -> str:
    """Run a command in a folder, on one core, and return its output."""
    variables = {**os.environ, "RAYON_NUM_THREADS": "1"}
    try:
        done = subprocess.run(
            words, cwd=folder, env=variables, capture_output=True, encoding="utf-8", check=False
        )
    except OSError as reason:
        raise RuntimeError(f"the worker cannot run {words[0]}: {reason.strerror}") from None
    if done.returncode != 0:
        raise RuntimeError(done.stderr.strip().removeprefix("squid: "))
    return done.stdout


def fly_fmus(name: str, flights: Sequence[dict]) -> bytes:
    """Simulate flights with the FMUs of plant and controller, and return their records in an archive."""
    folder, archive = folder_of(name), io.BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as records:
        for drawn in flights:
            records.writestr(f"flight-{drawn['flight']}.csv", record(folder, drawn))
    return archive.getvalue()


def record(folder: Path, drawn: dict) -> str:
    """Simulate a flight with its random values, and return its record as CSV.

    The record has no rows if the plant finds no initial trim or starts out of the waves, and ends early if numbers grow
    without bound.
    """
    rows: list[list[float]] = []
    try:
        with (
            Slave(folder / PLANT, "plant", quiet=True) as plant,
            Slave(folder / CONTROLLER, "controller", quiet=True) as controller,
        ):
            actuators = shared(controller, plant)
            followed = [f"{name}_used" for name in wanted_by(controller)]
            fly(plant, controller, drawn, rows)
    except FMICallException as error:
        # A number that is refused during the simulation has grown without bound.
        if not rows and error.function.startswith("fmi2Set"):
            raise
    head = ["time", *WATCHED, *followed, *actuators]
    return "\n".join(",".join(map(str, row)) for row in [head, *rows]) + "\n"


def fly(plant: Slave, controller: Slave, drawn: dict, rows: list[list[float]]) -> None:
    """Simulate plant and controller in one loop, as the native loop does, and add a row for each tick."""
    manoeuvre = drawn["manoeuvre"]
    sample_time = float(controller.variables["sample_time"].start)
    ticks = [k * sample_time for k in range(round(manoeuvre["duration"] / sample_time) + 1)]
    speed = float(path_speeds(manoeuvre, np.zeros(1))[0])
    plant.begin({"initial_speed": speed, **drawn["start"]})
    controller.begin()
    wanted = references(controller, manoeuvre, np.array(ticks), plant.get("initial_depth"))
    loop = Loop(plant, controller, drawn["gains"])
    loop.inform(wanted[0])
    # An actuator without lag follows the first command from the start.
    loop.command()
    plant.ready()
    controller.ready()
    watched = plant.references(WATCHED)
    names = wanted_by(controller)
    for k, time in enumerate(ticks):
        loop.inform(wanted[k])
        controller.step_to((k + 1) * sample_time)
        followed = [wanted[k][name] for name in names]
        rows.append([time, *plant.fmu.getReal(watched), *followed, *loop.command()])
        plant.step_to((k + 1) * sample_time)


def path_speeds(manoeuvre: dict, times: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the reference of the speed along the path (m/s) at each time."""
    part = np.clip((times - manoeuvre["ramp_start"]) / manoeuvre["ramp_duration"], 0.0, 1.0)
    return (1.0 - part) * manoeuvre["speed_from"] + part * manoeuvre["speed_to"]


def wanted_by(controller: Slave) -> list[str]:
    """Return the references of the record: always pitch and speed, and depth if the controller tracks it."""
    depth = ["depth_reference"] if "depth_reference" in controller.variables else []
    return ["pitch_reference", *depth, "speed_reference"]


def references(
    controller: Slave, manoeuvre: dict, times: NDArray[np.float64], depth: float
) -> list[dict[str, float]]:
    """Return the references at each time, from the controller's trims and the initial depth (m)."""
    design = controller.folder / "resources" / "controller.json"
    trim = json.loads(design.read_text(encoding="utf-8"))["trim"]
    speeds = np.interp(path_speeds(manoeuvre, times), trim["speed"], trim["forward_speed"])
    pitches = np.interp(speeds, trim["forward_speed"], trim["signals"]["pitch"])
    # A time k T rounded down is not before the step.
    stepped = (times + 1e-9 >= manoeuvre["step_time"]) & (times + 1e-9 < manoeuvre["step_end"])
    steps = manoeuvre["steps"]
    pitches = pitches + steps.get("pitch", 0.0) * stepped
    depths = depth + steps.get("depth", 0.0) * stepped
    rows = zip(pitches.tolist(), depths.tolist(), speeds.tolist(), strict=True)
    return [
        dict(zip(("pitch_reference", "depth_reference", "speed_reference"), row, strict=True)) for row in rows
    ]
