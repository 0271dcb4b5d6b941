"""Native programs of the tests: the small importer `tests/host/host.c`, and the emulators of other platforms."""

from __future__ import annotations

import os
import shutil
import subprocess
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from fly.master import Signals
from fly.stages import ROOT
from fmpy import read_model_description

SOURCE = ROOT / "tests" / "host" / "host.c"
WARNINGS = ("-std=c11", "-O2", "-Wall", "-Wextra", "-Werror")


def program(package: str, *names: str) -> str:
    """Return the path of a program, or skip the test if it is missing; in CI nothing is skipped."""
    found = next((path for path in map(shutil.which, names) if path), None)
    if found is None:
        reason = f"none of {', '.join(names)} is installed; on Debian and Ubuntu: apt install {package}"
        if os.environ.get("CI") == "true":
            pytest.fail(reason)
        pytest.skip(reason)
    return found


def compile_host(compiler: Sequence[str | Path], to: Path) -> Path:
    """Compile the importer; a warning is an error."""
    words = [*compiler, *WARNINGS, "-o", to, SOURCE]
    if to.suffix != ".exe":
        words += ["-ldl", "-lm", "-pthread"]
    subprocess.run(words, check=True)
    return to


@dataclass(frozen=True)
class Unpacked:
    """An unpacked FMU, as an importer without Python sees it."""

    folder: Path

    @classmethod
    def of(cls, fmu: Path, folder: Path) -> Unpacked:
        """Unpack an FMU into a new folder."""
        with zipfile.ZipFile(fmu) as archive:
            archive.extractall(folder)
        return cls(folder)

    @property
    def guid(self) -> str:
        """GUID of the model description."""
        return read_model_description(self.folder).guid

    def binary(self, platform: str) -> Path:
        """Return the only binary for a platform, by its name in FMI."""
        (found,) = (self.folder / "binaries" / platform).iterdir()
        return found

    def references(self, causality: str, kind: str = "Real") -> dict[str, int]:
        """Return the value references of the variables of a causality and a type."""
        variables = read_model_description(self.folder).modelVariables
        return {v.name: v.valueReference for v in variables if v.causality == causality and v.type == kind}

    def flight(
        self,
        host: Sequence[str | Path],
        platform: str,
        plan: Plan,
        root: str = "",
        variables: Mapping[str, str] | None = None,
    ) -> Signals:
        """Simulate with the importer; `root` is the prefix of absolute paths on the platform."""
        inputs, outputs = self.references("input"), self.references("output")
        resources = f"file:///{root.lstrip('/')}{(self.folder / 'resources').as_posix()}"
        values = [f"{inputs[name]}={value!r}" for name, value in plan.inputs.items()]
        words = [
            *(self.binary(platform), self.guid, resources, repr(plan.step), plan.count, plan.every),
            *(*values, *outputs.values()),
        ]
        done = subprocess.run(
            [*map(str, host), *map(str, words)],
            env={**os.environ, **(variables or {})},
            capture_output=True,
            text=True,
            timeout=300,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        rows = [[float(cell) for cell in line.split(",")] for line in done.stdout.splitlines()]
        assert len(rows) == plan.count // plan.every + 1
        return dict(zip(["time", *outputs], np.array(rows).T, strict=True))


@dataclass(frozen=True)
class Plan:
    """A simulation: constant inputs, communication step (s), number of steps, and steps between two rows."""

    inputs: Mapping[str, float]
    step: float
    count: int
    every: int
