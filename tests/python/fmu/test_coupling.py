"""Plant and controller coupled by a master, compared with both in one FMU."""

from __future__ import annotations

import json
import re
import shutil
import zipfile
from pathlib import Path

import numpy as np
import pytest
from conftest import REMUS100, Run, kept, package
from flights import engagement, fly_alone, limits, sample_time
from fly.flight import AGREEMENT
from fly.master import Signals, Slave, couple
from fly.package import Packages
from fly.record import differences, read, references_in
from fly.stages import ROOT
from fmpy import read_model_description
from fmpy.validation import validate_fmu

pytestmark = pytest.mark.change


def fly_loop(packages: Packages, step: float) -> Signals:
    return fly_alone(packages.loop, 40.0, step)


def couple_like(packages: Packages, loop: Signals, **values: float) -> Signals:
    with Slave(packages.plant, "plant") as plant, Slave(packages.controller, "controller") as controller:
        plant.begin({"initial_speed": float(loop["path_speed"][0]), **values})
        controller.begin()
        end = float(loop["time"][-1])
        return couple(plant, controller, references_in(loop), end, sample_time(packages))


@pytest.mark.parametrize("fidelity", [1, 2])
def test_coupled_is_the_same_flight(packages: Packages, fidelity: int) -> None:
    """The results agree for the nonlinear equations and for the LPV model at the reference speed."""
    loop = fly_alone(packages.loop, 40.0, sample_time(packages), {"fidelity": fidelity})
    coupled = couple_like(packages, loop, fidelity=fidelity)
    found = differences(loop, coupled)
    assert {"pitch", "speed", "depth", "distance", *limits(packages)} <= set(found)
    assert max(found.values()) <= AGREEMENT, found


def test_coupled_is_the_same_flight_in_six_degrees_of_freedom(turning: Packages) -> None:
    """The results agree for two axes: a turn by 10 degrees with a depth step, from a given heading."""
    start = {"initial_heading": 0.7}
    loop = fly_alone(turning.loop, 40.0, sample_time(turning), start)
    found = differences(loop, couple_like(turning, loop, **start))
    assert {"pitch", "heading", "roll", "sway", "north", "east", *limits(turning)} <= set(found)
    assert max(found.values()) <= AGREEMENT, found
    assert loop["heading"][-1] - 0.7 == pytest.approx(np.deg2rad(10.0), rel=0.01)
    assert np.ptp(loop["rudder"]) > 0.01 and np.ptp(loop["roll"]) > 1e-3


def test_it_is_the_flight_of_the_command(turning: Packages, run_squid: Run) -> None:
    """`squid simulate` simulates both axes without FMI, and records the manoeuvre with the ramp of speed.

    The sea is that of a file, whose numbers the FMU has as parameters.
    """
    sea = turning.folder / "sea.toml"
    waves = {"height": 0.5, "period": 6.0, "gamma": 3.3, "heading": 60.0}
    numbers = "".join(f"{key} = {value}\n" for key, value in waves.items())
    sea.write_text(f'seed = 3\n[waves]\nspectrum = "jonswap"\n{numbers}', encoding="utf-8")
    words = ("--turn", "10", "--sea", sea, "--out", turning.folder)
    done = run_squid("simulate", REMUS100, *words, cwd=ROOT)
    assert done.returncode == 0, done.stderr
    found = read(turning.folder / "turn.csv")
    recorded = {name.split(" [")[0]: values for name, values in found.items()}
    values = {"step_time": 10.0, "step_end": 1e6, "heading_step": float(np.deg2rad(10.0)), "wave_seed": 3}
    values |= {f"wave_{key}": value for key, value in waves.items() if key != "heading"}
    values |= {"wave_heading": float(np.deg2rad(waves["heading"]))}
    flown = fly_alone(turning.loop, float(recorded["time"][-1]), sample_time(turning), values)
    apart = {
        name: np.max(np.abs(flown[name] - recorded[name]))
        for name in ("pitch", "heading", "roll", "speed", "sway", "depth", "north", "east")
    }
    assert max(apart.values()) < 1e-9, apart
    assert np.ptp(recorded["wave_elevation"]) > 0.2 and np.ptp(recorded["current_east"]) > 0.01
    assert flown["heading"][-1] == pytest.approx(np.deg2rad(10.0), rel=0.1)


def test_actuators_without_lag(run_squid: Run, quick_vehicle: Path, tmp_path: Path) -> None:
    """Outputs of actuators without lag equal the commands from the first row on."""
    vehicle = Path(shutil.copytree(quick_vehicle, tmp_path / "vehicle"))
    file = vehicle / "vehicle.toml"
    text, count = re.subn(
        r"lag = \{ value = [0-9.]+", "lag = { value = 0.0", file.read_text(encoding="utf-8")
    )
    assert count == 4
    file.write_text(text, encoding="utf-8")
    packages = package(run_squid, vehicle, tmp_path / "out")
    loop = fly_loop(packages, sample_time(packages))
    found = differences(loop, couple_like(packages, loop))
    outputs = [name for name in found if name.endswith("_output")]
    assert len(outputs) == 3 and max(found.values()) <= AGREEMENT, found
    assert all(loop[name][0] == loop[name.removesuffix("_output")][0] for name in outputs)


SENSOR = """      "pitch_rate": {
        "error": 0.2,
        "rate": 2.0,
        "drift": 2.0
      },
"""
"""What its sensor may say, before that of the speed."""


def measuring_the_pitch_rate(design: str) -> str:
    """Give a frozen design the pitch rate as an unused input; numbers keep their notation."""
    further = {"signal": "pitch_rate", "kind": "measurement", "unit": "rad/s", "scale": 0.1}
    inputs = [*json.loads(design)["controller_inputs"], further]

    def one_column_more(matrix: re.Match) -> str:
        return re.sub(r"(?<=\d)\](?=,?\n)", ", 0.0]", matrix[0])

    listed = json.dumps({"controller_inputs": inputs}, indent=2)
    for pattern, becomes, times in (
        ('"certified": true', '"certified": false', 1),
        (r'  "controller_inputs": \[.*?\n  \],', listed.removeprefix("{\n").removesuffix("\n}") + ",", 1),
        (r'(?=      "speed": \{\n        "error")', SENSOR, 1),
        (r'"(?:By|Duy|Dty)": \[\n.*?\n    \]', one_column_more, 3),
    ):
        design, count = re.subn(pattern, becomes, design, flags=re.DOTALL)
        assert count == times, pattern
    return design


@pytest.fixture(scope="module")
def by_errors(squid_by_errors: Path, run_squid: Run) -> Packages:
    """Return the FMUs of Squid with a design whose controller uses tracking errors only."""
    return kept(run_squid, squid_by_errors)


@pytest.fixture(scope="module")
def with_pitch_rate(
    by_errors: Packages, squid_by_errors: Path, run_squid: Run, tmp_path_factory: pytest.TempPathFactory
) -> Packages:
    """Return the same FMUs with the pitch rate as an additional input."""
    folder, stored = tmp_path_factory.mktemp("second"), tmp_path_factory.mktemp("stored")
    for path in by_errors.folder.glob("*.json"):
        shutil.copy(path, stored)
    design = measuring_the_pitch_rate((stored / "controller.json").read_text(encoding="utf-8"))
    (stored / "controller.json").write_text(design, encoding="utf-8")
    words = (squid_by_errors, "--out", stored, "--descriptions", folder, "--allow-uncertified")
    done = run_squid("package", *words)
    assert done.returncode == 0, done.stderr
    for fmu in by_errors.fmus:
        replaced = {
            "modelDescription.xml": (folder / f"{fmu.stem}.xml").read_bytes(),
            "resources/controller.json": design.encode(),
        }
        with zipfile.ZipFile(fmu) as source, zipfile.ZipFile(folder / fmu.name, "w") as target:
            for entry in source.infolist():
                if not entry.filename.startswith(("terminalsAndIcons/terminals", "resources/certificate")):
                    target.writestr(entry, replaced.get(entry.filename, source.read(entry)))
    return Packages(folder, by_errors.vehicle)


def inputs_of(packages: Packages) -> list[str]:
    variables = read_model_description(packages.controller).modelVariables
    inputs = [variable.name for variable in variables if variable.causality == "input"]
    assert engagement(packages) <= set(inputs)
    return [name for name in inputs if name not in engagement(packages)]


def test_measurements_of_a_design_are_inputs(
    squid: Packages, by_errors: Packages, with_pitch_rate: Packages
) -> None:
    for fmu in with_pitch_rate.fmus:
        assert validate_fmu(fmu) == []
    references = ["pitch_reference", "speed_reference"]
    assert inputs_of(by_errors) == ["pitch", "speed", *references]
    assert inputs_of(with_pitch_rate) == inputs_of(squid) == ["pitch", "speed", "pitch_rate", *references]


def test_a_measurement_without_effect_changes_no_flight(
    by_errors: Packages, with_pitch_rate: Packages
) -> None:
    """The results agree in one loop and with the master, which passes the measurement."""
    loop = fly_loop(by_errors, sample_time(by_errors))
    for flown in (
        fly_loop(with_pitch_rate, sample_time(with_pitch_rate)),
        couple_like(with_pitch_rate, loop),
    ):
        assert max(differences(loop, flown).values()) <= AGREEMENT


def test_the_comparison_can_fail(squid: Packages) -> None:
    """A reference that comes one sample late is detected."""
    loop = fly_loop(squid, sample_time(squid))
    late = dict(loop)
    for name in ("pitch_reference_used", "speed_reference_used"):
        late[name] = np.concatenate([loop[name][:1], loop[name][:-1]])
    coupled = couple_like(squid, late)
    assert max(differences(loop, coupled).values()) > 1e3 * AGREEMENT


def test_inputs_override_the_manoeuvre(packages: Packages) -> None:
    """The manual inputs, fed with the manoeuvre's references, give the manoeuvre's result."""
    tick = sample_time(packages)
    loop = fly_loop(packages, tick)
    references = references_in(loop)

    def inputs(time: float) -> dict[str, float]:
        return {"manual": True, **references(round(time / tick), time)}

    manual = fly_alone(packages.loop, 40.0, tick, {"pitch_step": 0.0}, inputs)
    assert max(differences(loop, manual).values()) <= AGREEMENT
    unlike = fly_alone(packages.loop, 40.0, tick, {"pitch_step": 0.0})
    step = next(v for v in read_model_description(packages.loop).modelVariables if v.name == "pitch_step")
    assert np.max(np.abs(unlike["pitch"] - loop["pitch"])) > 0.5 * float(step.start)


@pytest.mark.parametrize("step", [0.01, 0.1, 0.00999999999999934, 1 / 3, 0.0171])
def test_loop_does_not_depend_on_the_communication_step(squid: Packages, step: float) -> None:
    """Ticks are at multiples of the sample time for any step of the importer; compared where both have rows."""
    base = fly_loop(squid, sample_time(squid))
    other = fly_loop(squid, step)
    ends = {name: abs(base[name][-1] - other[name][-1]) / max(1.0, abs(base[name][-1])) for name in base}
    assert max(ends.values()) < 1e-8, ends
