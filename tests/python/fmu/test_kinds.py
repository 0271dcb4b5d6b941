"""FMUs with one interface: output of `squid package --kind`, importers with one interface, and CasADi."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from conftest import SQUID, Run, messages
from fly.package import Packages
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.fmi2 import FMU2Model, FMU2Slave
from fmpy.model_description import ModelDescription
from fmpy.validation import validate_fmu
from importers import FOLDER, others
from syrupy.assertion import SnapshotAssertion

pytestmark = pytest.mark.change

OF_KIND = {"cs": ("coSimulation", "modelExchange"), "me": ("modelExchange", "coSimulation")}
"""The element of the model description that an FMU of a kind has, and the one that it lacks."""
FMUS = {"cs": ("plant", "controller", "loop"), "me": ("plant", "loop")}
RESULTS = ("pitch", "speed", "depth")


def packaged(run_squid: Run, squid: Packages, folder: Path, *options: str) -> Packages:
    """Package the stored design of Squid into a folder that already has FMUs of both interfaces."""
    shutil.copytree(squid.folder, folder)
    done = run_squid("package", SQUID, "--out", folder, *options)
    assert done.returncode == 0, done.stderr
    return Packages.found_in(folder)


@pytest.fixture(scope="session")
def by_kind(run_squid: Run, squid: Packages, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Packages]:
    """Return the FMUs of Squid of each kind."""
    folder = tmp_path_factory.mktemp("kinds")
    return {kind: packaged(run_squid, squid, folder / kind, "--kind", kind) for kind in OF_KIND}


@pytest.mark.parametrize("kind", OF_KIND)
def test_an_fmu_offers_its_kind_alone(by_kind: dict[str, Packages], squid: Packages, kind: str) -> None:
    has, lacks = OF_KIND[kind]
    for name in FMUS[kind]:
        fmu = getattr(by_kind[kind], name)
        assert validate_fmu(str(fmu)) == []
        described, of_both = read_model_description(fmu), read_model_description(getattr(squid, name))
        assert getattr(described, lacks) is None
        assert getattr(described, has).modelIdentifier == fmu.stem
        assert described.guid != of_both.guid
        assert [v.name for v in described.modelVariables] == [v.name for v in of_both.modelVariables]


def test_what_is_for_co_simulation_is_not_written_for_model_exchange(
    by_kind: dict[str, Packages], squid: Packages
) -> None:
    written = {
        kind: {path.name for pattern in ("*.fmu", "*.ssp") for path in packages.folder.glob(pattern)}
        for kind, packages in by_kind.items()
    }
    assert written["cs"] == {"squid_plant.fmu", "squid_controller.fmu", "squid.fmu", "squid.ssp"}
    assert written["me"] == {"squid_plant.fmu", "squid.fmu"}, "those of an earlier run are removed, too"


@pytest.mark.parametrize("kind", OF_KIND)
def test_an_fmu_of_a_kind_flies_as_one_of_both(
    by_kind: dict[str, Packages], squid: Packages, kind: str
) -> None:
    has = OF_KIND[kind][0]
    interface = has[0].upper() + has[1:]
    options = {"output": RESULTS, "stop_time": 12.0, "output_interval": 0.1, "fmi_type": interface}
    rows = simulate_fmu(by_kind[kind].loop, **options)
    expected = simulate_fmu(squid.loop, **options)
    assert np.ptp(rows["pitch"]) > 0.01
    for name in RESULTS:
        assert np.array_equal(rows[name], expected[name]), name


@pytest.mark.parametrize("kind", OF_KIND)
def test_the_other_interface_is_refused_in_a_sentence(
    by_kind: dict[str, Packages],
    kind: str,
    tmp_path: Path,
    capfd: pytest.CaptureFixture,
    snapshot: SnapshotAssertion,
) -> None:
    """The call is refused even if the importer does not read which interfaces the model description offers."""
    importer = {"cs": FMU2Model, "me": FMU2Slave}[kind]
    for name in FMUS[kind]:
        fmu = getattr(by_kind[kind], name)
        folder = extract(fmu, tmp_path / name)
        instance = importer(
            guid=read_model_description(folder).guid,
            unzipDirectory=folder,
            modelIdentifier=fmu.stem,
            instanceName="one",
        )
        with pytest.raises(Exception, match="instantiate"):
            instance.instantiate()
        assert capfd.readouterr().out == snapshot(name=name)


@pytest.mark.parametrize("kind", OF_KIND)
def test_an_fmu_of_a_kind_is_verified(run_squid: Run, by_kind: dict[str, Packages], kind: str) -> None:
    done = run_squid("verify", by_kind[kind].loop, "--vehicle", SQUID)
    assert done.returncode == 0, done.stderr


def test_an_unknown_kind_is_refused(run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion) -> None:
    done = run_squid("package", SQUID, "--out", tmp_path, "--kind", "se")
    assert done.returncode == 64 and messages(done) == snapshot
    assert list(tmp_path.iterdir()) == []


class Plant:
    """The plant in model exchange with FMPy, in continuous-time mode, at its start values."""

    def __init__(self, fmu: Path, folder: Path) -> None:
        unpacked = extract(fmu, folder)
        self.description: ModelDescription = read_model_description(unpacked)
        self.fmu = FMU2Model(
            guid=self.description.guid,
            unzipDirectory=unpacked,
            modelIdentifier=fmu.stem,
            instanceName="plant",
        )
        self.rates = [unknown.variable for unknown in self.description.derivatives]
        self.states = [variable.derivative for variable in self.rates]
        self.inputs = [v for v in self.description.modelVariables if v.causality == "input"]
        self.fmu.instantiate()
        self.fmu.setupExperiment()
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        self.fmu.newDiscreteStates()
        self.fmu.enterContinuousTimeMode()

    def values(self, variables: list) -> list[float]:
        """Return the values of variables."""
        return self.fmu.getReal([variable.valueReference for variable in variables])

    def at(self, point: list[float]) -> tuple[list[float], np.ndarray]:
        """Return the derivatives at a point, and their Jacobian."""
        self.fmu.setContinuousStates((np.ctypeslib.as_ctypes(np.array(point))), len(point))
        unknowns = [variable.valueReference for variable in self.rates]
        columns = [
            self.fmu.getDirectionalDerivative(unknowns, [state.valueReference], [1.0])
            for state in self.states
        ]
        return self.values(self.rates), np.array(columns).T


@pytest.mark.parametrize("kind", ["me", "both"])
def test_casadi_evaluates_and_integrates(
    by_kind: dict[str, Packages], squid: Packages, kind: str, tmp_path: Path
) -> None:
    """CasADi sets the states by fmi2SetReal."""
    fmu = (squid if kind == "both" else by_kind["me"]).plant
    plant = Plant(fmu, tmp_path / "fmpy")
    start = np.array(plant.values(plant.states))
    shifts = np.random.default_rng(7).normal(size=(3, len(start))) * 0.05
    points = [start.tolist(), *(start + shifts).tolist()]
    duration = 5.0
    plan = {
        "fmu": str(fmu),
        "states": [variable.name for variable in plant.states],
        "inputs": [variable.name for variable in plant.inputs],
        "held": plant.values(plant.inputs),
        "points": points,
        "duration": duration,
        "tolerance": 1e-10,
        "out": str(tmp_path / "out.json"),
    }
    plan["held"][0] += 5.0
    plant.fmu.setReal([plant.inputs[0].valueReference], [plan["held"][0]])
    (tmp_path / "plan.json").write_text(json.dumps(plan), encoding="utf-8")
    command = [others().python, FOLDER / "derivatives_casadi.py", tmp_path / "plan.json"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    found = json.loads((tmp_path / "out.json").read_text(encoding="utf-8"))

    assert not np.allclose(found["rates"][0], found["rates"][1], atol=1e-3), "the states were set"
    for point, rates, jacobian in zip(points, found["rates"], found["jacobians"], strict=True):
        expected = plant.at(point)
        np.testing.assert_allclose(rates, expected[0], rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(jacobian, expected[1], rtol=1e-9, atol=1e-12)
    flown = simulate_fmu(
        squid.plant,
        fmi_type="CoSimulation",
        start_values={plant.inputs[0].name: plan["held"][0]},
        output=plan["states"],
        stop_time=duration,
        output_interval=duration,
    )[-1]
    np.testing.assert_allclose(found["end"], [flown[name] for name in plan["states"]], rtol=1e-6, atol=1e-6)
