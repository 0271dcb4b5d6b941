"""The simulations of `run.py fly`: validate, simulate in one FMU and coupled, compare, plot, print the figures."""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
from pathlib import Path

import numpy as np
from fmpy import read_model_description
from fmpy.validation import validate_fmu

from fly import record
from fly.master import Signals, Slave, couple
from fly.package import Packages
from fly.stages import StageError, answer, run, stage

AGREEMENT = 1e-9
"""Largest difference between the two flights: the same arithmetic, except for the rounding of time."""


def validate(packages: Packages) -> None:
    """Validate each FMU with FMPy."""
    for fmu in packages.fmus:
        problems = validate_fmu(str(fmu))
        if problems:
            raise StageError(f"{fmu.name} is not valid:\n  " + "\n  ".join(problems))
        print(f"    {fmu.name}: no problems ({fmu.stat().st_size / 1e6:.2f} MB)")


def sample_time_of(packages: Packages) -> float:
    """Return the sample time of the controller (s)."""
    description = read_model_description(packages.controller)
    return next(float(v.start) for v in description.modelVariables if v.name == "sample_time")


def fly_loop(packages: Packages) -> Signals:
    """Simulate the manoeuvre of the loop FMU with the command line of FMPy."""
    stop = read_model_description(packages.loop).defaultExperiment.stopTime
    path = packages.folder / "flight.csv"
    interval = ["--output-interval", repr(sample_time_of(packages)), "--stop-time", str(stop)]
    command = [sys.executable, "-m", "fmpy", "simulate", packages.loop, *interval, "--output-file", path]
    run(command, log="fmpy-simulate")
    return record.read(path)


def fly_coupled(packages: Packages, loop: Signals) -> Signals:
    """Simulate plant and controller coupled by the master, with the same start and the same references."""
    end, sample_time = float(loop["time"][-1]), sample_time_of(packages)
    with (
        Slave(packages.loop, "loop") as whole,
        Slave(packages.plant, "plant") as plant,
        Slave(packages.controller, "controller") as controller,
    ):
        whole.begin()
        whole.ready()
        own = set(plant.names("parameter") + plant.names("parameter", "Enumeration"))
        start = {name: whole.get(name) for name in whole.start_values() if name in own}
        plant.begin({**start, "initial_speed": float(loop["path_speed"][0])})
        controller.begin()
        return couple(plant, controller, record.references_in(loop), end, sample_time)


def compare(loop: Signals, coupled: Signals) -> float:
    """Return the largest difference between the two simulations; raise an error above `AGREEMENT`."""
    differences = record.differences(loop, coupled)
    name, worst = max(differences.items(), key=lambda item: item[1])
    print(
        f"    {len(differences)} signals over {len(loop['time'])} samples; largest difference {worst:.1e} in {name}"
    )
    if not worst <= AGREEMENT:
        raise StageError(
            f"the coupled flight differs from that in one FMU by {worst:.3e} in {name}; allowed is {AGREEMENT:.0e}."
        )
    return worst


def plot(packages: Packages, squid: Path, vehicle: Path) -> dict:
    """Plot the simulation, and return its figures, which `squid plot --help` explains."""
    record_file, drawn = packages.folder / "flight.csv", packages.folder / "flight.svg"
    return json.loads(answer([squid, "plot", record_file, "--vehicle", vehicle, "--out", drawn, "--json"]))


def report(packages: Packages, figures: dict, agreement: float, whole: str) -> None:
    """Print the results; figures and plot end at the surface, because the equations hold in deep water."""
    print(f"\nResults, {packages.vehicle}")
    lines = [
        *(line for path in packages.figures for line in gamma_lines(path, len(packages.figures) > 1)),
        *(line for output in OUTPUTS for line in tracking_lines(figures, *output)),
        ("speed tracking", f"error at most {figures['speed_error']:.3f} m/s"),
        *surface_lines(figures["surface"]),
        ("actuators", f"{100 * figures['actuator_use']:.0f} % of their limits at most"),
        ("two flights agree", f"to {agreement:.1e} (coupled by the master; in one FMU by fmpy simulate)"),
        ("plot", os.path.relpath(figures["plot"])),
        ("the whole report", whole),
    ]
    for name, value in lines:
        print(f"  {name:<18} {value}")


OUTPUTS = (("pitch", 180.0 / math.pi, "deg"), ("depth", 1.0, "m"), ("heading", 180.0 / math.pi, "deg"))
"""Outputs that step, each with how many of a unit one of SI is; depth and heading are there where they are tracked."""


def tracking_lines(figures: dict, name: str, factor: float, unit: str) -> list[tuple[str, str]]:
    """Return the lines on the error and the steps of an output."""
    if f"{name}_steps" not in figures:
        return []
    steps, off = figures[f"{name}_steps"], figures[f"{name}_error"]
    tracking = "not flown" if off is None else f"error at most {factor * off:.3f} {unit}"
    when = f"later than {figures['grace']:.0f} s after a step" if steps else "with no step"
    told = [
        (f"step at {step['time']:g} s", describe(step, figures["settled"], factor, unit)) for step in steps
    ]
    return [(f"{name} tracking", f"{tracking}, {when}"), *told]


def surface_lines(surface: dict | None) -> list[tuple[str, str]]:
    """Return the line on when the vehicle reached the surface, if it did."""
    if surface is None:
        return []
    reached = f"reached at {surface['time']:.2f} s with {surface['speed']:.2f} m/s"
    return [("SURFACE", f"{reached}; plot and figures end there, flight.csv continues")]


def gamma_lines(figures: Path, is_axis: bool) -> list[tuple[str, str]]:
    """Return the lines on the gain of the closed loop of a design, or of one of its axes."""
    achieved = json.loads(figures.read_text(encoding="utf-8"))
    name = f"gamma, {figures.parent.name}" if is_axis else "gamma"
    proof = "PROVED in exact arithmetic" if achieved["certified"] else "not proved"
    bound, optimum, back_off = (achieved[key] for key in ("gamma_bound", "gamma_optimum", "back_off"))
    what = f"a bound of the loop's L2 gain for any trajectory of speed ({proof})"
    lines = [(name, f"{rounded_up(bound):.4f}, {what}")]
    with_error = achieved["gamma_bound_with_model_error"]
    if with_error is not None:
        covered = f"{rounded_up(with_error):.4f}, for every model in a ball around the fit (proved)"
        lines.append(("  off the fit", covered))
    return [*lines, ("least gamma", f"{optimum:.4f}; the controller is built {100 * back_off:.1f} % above")]


def rounded_up(bound: float) -> float:
    """Return an upper bound rounded up to four decimals."""
    return np.ceil(1e4 * bound) / 1e4


def describe(step: dict, settled: float, factor: float, unit: str) -> str:
    """Return overshoot and settling time of one step response."""
    band, time = f"within {100 * settled:.0f} %", step["settling_time"]
    when = f"never {band}" if time is None else f"{band} after {time:.1f} s"
    return f"{factor * step['height']:+.1f} {unit}: overshoot {100 * step['overshoot']:.1f} %, {when}"


def main() -> int:
    """Run the simulations and return the exit code."""
    parser = argparse.ArgumentParser(prog="fly.flight", description=__doc__)
    parser.add_argument("folder", type=Path, help="folder with the three FMUs")
    parser.add_argument("squid", type=Path, help="the command squid")
    parser.add_argument("vehicle", type=Path, help="directory of the vehicle that flies")
    parser.add_argument("report", help="the command that writes the whole report, which is named at the end")
    arguments = parser.parse_args()
    try:
        packages = Packages.found_in(arguments.folder)
        with stage("Validating the FMUs with FMPy"):
            validate(packages)
        with stage(f"Flying {packages.loop.name} with `fmpy simulate`"):
            loop = fly_loop(packages)
        with stage(f"Flying {packages.plant.name} and {packages.controller.name} coupled by the master"):
            coupled = fly_coupled(packages, loop)
        with stage("Comparing the two flights"):
            agreement = compare(loop, coupled)
        with stage("Drawing the flight"):
            figures = plot(packages, arguments.squid, arguments.vehicle)
        report(packages, figures, agreement, arguments.report)
    except StageError as error:
        print(f"\nStopped: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
