"""Shared fixtures: the command, and the FMUs of two vehicles, packaged once into a temporary directory."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest
from fly import build
from fly.package import Packages
from fly.stages import ROOT

Run = Callable[..., subprocess.CompletedProcess]


@pytest.fixture(scope="session")
def squid_command() -> Path:
    """Return the command `squid`, with the binaries of the FMUs built beside it."""
    build.build()
    return build.squid()


@pytest.fixture(scope="session")
def run_squid(squid_command: Path) -> Run:
    """Return a function that runs `squid` with arguments and hands back exit code and output."""

    def run(*words: str | Path, timeout: float = 300.0) -> subprocess.CompletedProcess:
        command = [squid_command, *map(str, words)]
        return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=timeout, check=False)

    return run


def package(run_squid: Run, vehicle: Path, folder: Path, *options: str) -> Packages:
    """Design and package a vehicle into a folder."""
    for verb in ("design", "package"):
        done = run_squid(verb, vehicle, "--out", folder, *options)
        assert done.returncode == 0, f"squid {verb}:\n{done.stdout}\n{done.stderr}"
    return Packages.found_in(folder)


@pytest.fixture(scope="session")
def squid(run_squid: Run, tmp_path_factory: pytest.TempPathFactory) -> Packages:
    """Return the FMUs of the surrogate of Squid."""
    return package(run_squid, ROOT / "vehicles" / "squid", tmp_path_factory.mktemp("squid"))


@pytest.fixture(scope="session")
def remus100(run_squid: Run, tmp_path_factory: pytest.TempPathFactory) -> Packages:
    """Return the FMUs of REMUS 100, which steers by stern planes."""
    return package(run_squid, ROOT / "vehicles" / "remus100", tmp_path_factory.mktemp("remus100"))


@pytest.fixture(params=["squid", "remus100"])
def packages(request: pytest.FixtureRequest) -> Packages:
    """Return the FMUs of each vehicle in turn."""
    return request.getfixturevalue(request.param)


@pytest.fixture
def copied_vehicle(tmp_path: Path) -> Path:
    """Return a copy of the vehicle of Squid that a test may spoil."""
    copy = tmp_path / "vehicle"
    shutil.copytree(ROOT / "vehicles" / "squid", copy)
    return copy
