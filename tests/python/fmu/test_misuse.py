"""Misuse is refused with an error and a logged sentence, and never crashes the importer."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import masked
from fly.master import Slave
from fly.package import Packages
from fly.stages import ROOT
from fmpy.fmi1 import FMICallException
from misuse_probe import CASES, NOT_INSTANTIATED
from syrupy.assertion import SnapshotAssertion

pytestmark = pytest.mark.change

ERROR = 3
AT_INSTANTIATION = {
    "wrong_guid": "GUID",
    "no_resources": "resources",
    "missing_resource": "resources/.*missing",
    "truncated_resource": "resources/",
    "binary_resource": "resources/",
    "changed_resource": "GUID",
    "changed_certificate": "GUID",
    "null_resource_location": "NULL",
}
WHILE_RUNNING = {
    "nan_input": ("SetReal", "NaN"),
    "infinite_input": ("SetReal", "inf"),
    "zero_step": ("DoStep", " 0 s"),
    "negative_step": ("DoStep", " -0.1 s"),
    "nan_step": ("DoStep", "NaN"),
    "gap_between_steps": ("DoStep", " 0.1 s"),
    "step_before_initialisation": ("DoStep", "instantiated"),
    "step_after_the_end": ("DoStep", "terminated"),
    "initialise_twice": ("EnterInitializationMode", "complete"),
    "unknown_reference_get": ("GetReal", "4000000000"),
    "unknown_reference_set": ("SetReal", "4000000000"),
    "wrong_type": ("GetString", "type"),
    "set_an_output": ("SetReal", " set"),
}
"""The refused function, and what its message names."""
REFUSED = {case: ("Instantiate", named) for case, named in AT_INSTANTIATION.items()} | WHILE_RUNNING


def probe(fmu: Path, case: str) -> tuple[int, str]:
    """Misuse an FMU in a process of its own; return the status and the log."""
    script = ROOT / "tests" / "python" / "support" / "misuse_probe.py"
    done = subprocess.run(
        [sys.executable, script, fmu, case], capture_output=True, text=True, timeout=60, check=False
    )
    assert done.returncode == 0, f"the process died with {done.returncode}:\n{done.stdout}\n{done.stderr}"
    found = re.search(r"^status (\d+)$", done.stdout, re.MULTILINE)
    assert found, done.stdout
    return int(found[1]), done.stdout


def test_every_case_is_tested() -> None:
    assert set(CASES) == set(REFUSED)


@pytest.mark.parametrize("kind", ["plant", "controller", "loop"])
@pytest.mark.parametrize("case", REFUSED)
def test_misuse_is_refused_in_a_sentence(squid: Packages, kind: str, case: str) -> None:
    status, log = probe(getattr(squid, kind), case)
    expected = NOT_INSTANTIATED if case in AT_INSTANTIATION else ERROR
    assert status == expected, log
    function, named = REFUSED[case]
    assert re.search(rf"^\[ERROR\] fmi2{function}: .*{named}.*\.$", log, re.MULTILINE), log
    assert "panic" not in log


def test_a_refused_call_changes_nothing(squid: Packages) -> None:
    """After a refusal the instance continues as if the call had not been made."""
    with Slave(squid.loop, "patient") as loop, Slave(squid.loop, "left alone") as other:
        for slave in (loop, other):
            slave.begin()
            slave.ready()
            slave.step_to(1.0)
        with pytest.raises(FMICallException):
            loop.fmu.doStep(1.0, -1.0)
        with pytest.raises(FMICallException):
            loop.set("current_horizontal", float("nan"))
        with pytest.raises(FMICallException):
            loop.set("pitch_step", 0.3)
        for slave in (loop, other):
            slave.step_to(20.0)
        names = loop.names("output")
        assert [loop.get(name) for name in names] == [other.get(name) for name in names]


@pytest.mark.parametrize(
    ("name", "value"), [("initial_depth", -1.0), ("initial_speed", 0.0), ("mass", -5.0), ("buoyancy", 1e6)]
)
def test_an_impossible_start_is_refused(
    squid: Packages, capsys: pytest.CaptureFixture[str], name: str, value: float
) -> None:
    with Slave(squid.plant, "impossible") as plant:
        plant.begin({name: value})
        with pytest.raises(FMICallException) as refused:
            plant.ready()
        assert refused.value.status == ERROR
        assert re.search(r"^\[ERROR\] fmi2\w+: .+\.$", capsys.readouterr().out, re.MULTILINE)
        plant.fmu.reset()
        plant.begin()
        plant.ready()


def test_a_slow_vehicle_warns_once_per_entry(
    squid: Packages, capsys: pytest.CaptureFixture[str], snapshot: SnapshotAssertion
) -> None:
    with Slave(squid.controller, "slow") as controller:
        controller.begin()
        controller.ready()
        for k, speed in enumerate([1.0, 0.45, 0.1, 0.1, 0.6, 1.0, 0.45]):
            controller.set("speed", speed)
            controller.step_to((k + 1) * 0.1)
    warnings = capsys.readouterr().out.splitlines()
    assert all(" 0.45 m/s" in warning for warning in warnings)
    assert [masked(warning) for warning in warnings] == snapshot
