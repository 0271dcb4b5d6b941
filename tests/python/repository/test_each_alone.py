"""Each FMU alone, in FMPy's simulation loop."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from conftest import Run
from flights import figures_of, limits, sample_time
from fly.package import Packages
from fmpy import read_model_description, simulate_fmu

pytestmark = pytest.mark.change


def test_plant_holds_its_trim(packages: Packages) -> None:
    """With the trim commands held, only rounding moves an open-loop stable vehicle out of trim."""
    description = read_model_description(packages.plant)
    names = [v.name for v in description.modelVariables if v.causality == "output"]
    at_start = simulate_fmu(packages.plant, stop_time=0.01, output=names)
    held = {name: float(at_start[f"trim_{name}"][0]) for name in limits(packages)}
    flown = simulate_fmu(packages.plant, stop_time=20.0, output=names, start_values=held)
    assert flown["time"][-1] == pytest.approx(20.0)
    assert np.ptp(flown["pitch"]) < 1e-6
    assert np.ptp(flown["speed"]) < 1e-6
    assert np.ptp(flown["depth"]) < 1e-5
    expected = 20.0 * flown["path_speed"][0]
    assert flown["distance"][-1] == pytest.approx(expected, rel=1e-6)


def test_controller_at_rest_commands_the_trim(packages: Packages) -> None:
    """The default inputs are level flight, so the errors are zero and only the feedforward remains."""
    flown = simulate_fmu(packages.controller, stop_time=5.0, output_interval=sample_time(packages))
    for name, (low, high) in limits(packages).items():
        assert np.ptp(flown[name]) < 1e-9 * (high - low)
        assert np.all((flown[name] > low) & (flown[name] < high))
    assert np.all(np.abs(flown["scheduling_parameter"]) < 1e-6)


def test_controller_pushes_the_right_way(squid: Packages) -> None:
    """The lower thruster raises the bow, the upper ones lower it; all push forward."""
    wanted = {"pitch": 0.0, "pitch_reference": 0.05}
    up = simulate_fmu(squid.controller, stop_time=1.0, start_values=wanted)
    level = simulate_fmu(squid.controller, stop_time=1.0, start_values={"pitch": 0.0, "pitch_reference": 0.0})
    assert up["lower"][-1] > level["lower"][-1]
    assert up["upper_port"][-1] < level["upper_port"][-1]
    accuracy_of_the_solver = 1e-6 * 160.0
    assert up["upper_port"][-1] == pytest.approx(up["upper_starboard"][-1], abs=accuracy_of_the_solver)


def test_loop_flies_its_manoeuvre(packages: Packages, run_squid: Run, tmp_path: Path) -> None:
    description = read_model_description(packages.loop)
    names = [v.name for v in description.modelVariables if v.causality == "output"]
    flown = simulate_fmu(packages.loop, output_interval=sample_time(packages), output=names)
    assert flown["time"][-1] == pytest.approx(float(description.defaultExperiment.stopTime))
    steps = figures_of(run_squid, {name: flown[name] for name in flown.dtype.names}, tmp_path)["pitch_steps"]
    assert steps, "the manoeuvre has a pitch step"
    wanted = {"squid": 10.0, "remus100": 3.0}[packages.vehicle]
    assert np.rad2deg(steps[0]["height"]) == pytest.approx(wanted, abs=0.1)
    assert np.ptp(flown["speed_reference_used"]) > 0.5, "the speed ramps"
