"""Misuse an FMU in one way and print the outcome; a crash ends this process, not the tests.

python misuse_probe.py FMU CASE     prints lines of the FMU's log, then `status N` (5: instantiation was refused)
"""

from __future__ import annotations

import math
import shutil
import sys
from collections.abc import Callable
from ctypes import byref
from pathlib import Path

from fmpy import extract, read_model_description
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave, defaultCallbacks, fmi2CoSimulation

NOT_INSTANTIATED = 5
UNKNOWN = 4_000_000_000


class Probe:
    """One instance under misuse."""

    def __init__(self, fmu: str) -> None:
        self.folder = Path(extract(fmu))
        description = read_model_description(self.folder)
        self.guid = description.guid
        self.identifier = description.coSimulation.modelIdentifier
        self.variables = description.modelVariables
        self.fmu: FMU2Slave | None = None

    def resources(self) -> list[Path]:
        """Return the files of the frozen design that the model reads; the certificate is for `squid verify`."""
        files = sorted(path for path in (self.folder / "resources").iterdir() if path.is_file())
        return [path for path in files if path.name != "certificate.json"]

    def one(self, causality: str, kind: str = "Real") -> int:
        """Return the value reference of some variable of a causality and a type."""
        found = (v for v in self.variables if v.causality == causality and v.type == kind)
        return next(found).valueReference

    def load(self, guid: str | None = None) -> FMU2Slave:
        """Load the binary."""
        self.fmu = FMU2Slave(
            guid=guid or self.guid,
            unzipDirectory=str(self.folder),
            modelIdentifier=self.identifier,
            instanceName="probe",
        )
        return self.fmu

    def instantiated(self) -> FMU2Slave:
        """Return a fresh instance."""
        fmu = self.load()
        fmu.instantiate()
        return fmu

    def running(self) -> FMU2Slave:
        """Return an instance after its initialisation."""
        fmu = self.instantiated()
        fmu.setupExperiment(startTime=0.0)
        fmu.enterInitializationMode()
        fmu.exitInitializationMode()
        return fmu


def no_resources(probe: Probe) -> None:
    """Instantiate without the folder of resources."""
    shutil.rmtree(probe.folder / "resources")
    probe.load().instantiate()


def missing_resource(probe: Probe) -> None:
    """Instantiate without one file."""
    probe.resources()[0].unlink()
    probe.load().instantiate()


def truncated_resource(probe: Probe) -> None:
    """Instantiate with half a file."""
    path = probe.resources()[0]
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    probe.load().instantiate()


def binary_resource(probe: Probe) -> None:
    """Instantiate with bytes that are not text."""
    probe.resources()[0].write_bytes(bytes(range(256)) * 8)
    probe.load().instantiate()


def changed_resource(probe: Probe) -> None:
    """Instantiate with a valid file other than the one of the model description."""
    path = probe.resources()[0]
    path.write_text(path.read_text(encoding="utf-8").replace("0.", "0.0", 1), encoding="utf-8")
    probe.load().instantiate()


def changed_certificate(probe: Probe) -> None:
    """Instantiate with a certificate other than the packed one, if there is one."""
    path = probe.folder / "resources" / "certificate.json"
    path.write_text(path.read_text(encoding="utf-8") + " " if path.exists() else "{}", encoding="utf-8")
    probe.load().instantiate()


def null_resource_location(probe: Probe) -> None:
    """Instantiate with NULL for the folder of resources."""
    fmu = probe.load()
    callbacks, name, guid = byref(defaultCallbacks), b"probe", probe.guid.encode()
    if fmu.fmi2Instantiate(name, fmi2CoSimulation, guid, None, callbacks, 0, 0) is None:
        raise RuntimeError("refused")


def gap_between_steps(probe: Probe) -> None:
    """Start a step at another time than the end of the last one."""
    fmu = probe.running()
    fmu.doStep(0.0, 0.1)
    fmu.doStep(0.5, 0.1)


def step_after_the_end(probe: Probe) -> None:
    """Step a terminated instance."""
    fmu = probe.running()
    fmu.terminate()
    fmu.doStep(0.0, 0.1)


CASES: dict[str, Callable[[Probe], None]] = {
    "wrong_guid": lambda probe: probe.load("{00000000-0000-0000-0000-000000000000}").instantiate(),
    "no_resources": no_resources,
    "missing_resource": missing_resource,
    "truncated_resource": truncated_resource,
    "binary_resource": binary_resource,
    "changed_resource": changed_resource,
    "changed_certificate": changed_certificate,
    "null_resource_location": null_resource_location,
    "nan_input": lambda probe: probe.running().setReal([probe.one("input")], [math.nan]),
    "infinite_input": lambda probe: probe.running().setReal([probe.one("input")], [math.inf]),
    "zero_step": lambda probe: probe.running().doStep(0.0, 0.0),
    "negative_step": lambda probe: probe.running().doStep(0.0, -0.1),
    "nan_step": lambda probe: probe.running().doStep(0.0, math.nan),
    "gap_between_steps": gap_between_steps,
    "step_before_initialisation": lambda probe: probe.instantiated().doStep(0.0, 0.1),
    "step_after_the_end": step_after_the_end,
    "initialise_twice": lambda probe: probe.running().enterInitializationMode(),
    "unknown_reference_get": lambda probe: probe.running().getReal([UNKNOWN]),
    "unknown_reference_set": lambda probe: probe.running().setReal([UNKNOWN], [1.0]),
    "wrong_type": lambda probe: probe.running().getString([probe.one("output")]),
    "set_an_output": lambda probe: probe.running().setReal([probe.one("output")], [1.0]),
}
"""The misuses by their names."""


def status_of(case: Callable[[Probe], None], probe: Probe) -> int:
    """Misuse the FMU, free it, and return its status."""
    try:
        case(probe)
    except FMICallException as error:
        probe.fmu.freeInstance()
        return error.status
    except Exception:
        if probe.fmu is None or getattr(probe.fmu, "component", None) is not None:
            raise
        return NOT_INSTANTIATED
    return 0


def main() -> None:
    """Run one case."""
    probe = Probe(sys.argv[1])
    try:
        status = status_of(CASES[sys.argv[2]], probe)
    finally:
        shutil.rmtree(probe.folder, ignore_errors=True)
    print(f"status {status}", flush=True)


if __name__ == "__main__":
    main()
