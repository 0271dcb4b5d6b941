"""Checks that importers make before an FMU runs."""

from __future__ import annotations

import os
import re
import stat
import zipfile
from collections import Counter
from itertools import pairwise
from pathlib import Path

import pytest
from fly.package import Packages
from fly.stages import ROOT
from fmpy import platform, read_model_description, supported_platforms
from fmpy.validation import validate_fmu

pytestmark = pytest.mark.change

KINDS = ["plant", "controller", "loop"]


@pytest.fixture
def packages(all_packages: Packages) -> Packages:
    """Return the FMUs of each vehicle in turn, in six degrees of freedom, too."""
    return all_packages


@pytest.fixture(params=KINDS)
def fmu(packages: Packages, request: pytest.FixtureRequest) -> Path:
    """Return each FMU in turn."""
    return getattr(packages, request.param)


def test_fmpy_finds_no_problem(fmu: Path) -> None:
    assert validate_fmu(str(fmu)) == []


def test_names_binary_and_platform(fmu: Path) -> None:
    description = read_model_description(fmu)
    assert description.fmiVersion == "2.0"
    assert description.coSimulation.modelIdentifier == fmu.stem
    assert supported_platforms(fmu) == [platform]


def test_start_values_lie_within_limits(fmu: Path) -> None:
    for variable in read_model_description(fmu).modelVariables:
        if variable.start is None or variable.type not in ("Real", "Integer", "Enumeration"):
            continue
        low = float("-inf") if variable.min is None else float(variable.min)
        high = float("inf") if variable.max is None else float(variable.max)
        assert low <= float(variable.start) <= high, variable.name


def test_outputs_are_listed_once(fmu: Path) -> None:
    description = read_model_description(fmu)
    listed = Counter(unknown.variable.name for unknown in description.outputs)
    outputs = [v.name for v in description.modelVariables if v.causality == "output"]
    assert listed == Counter(outputs)
    assert outputs


def test_every_variable_explains_itself(fmu: Path) -> None:
    for variable in read_model_description(fmu).modelVariables:
        assert variable.description, variable.name
        assert variable.type != "Real" or variable.unit, f"{variable.name} has no unit"


def test_angles_are_shown_in_degrees(fmu: Path) -> None:
    angles = [v for v in read_model_description(fmu).modelVariables if v.unit == "rad"]
    assert angles
    assert {v.displayUnit for v in angles} == {"deg"}


def test_says_where_the_coefficients_come_from(packages: Packages) -> None:
    word = {"squid": "surrogate", "remus100": "published"}[packages.vehicle]
    for fmu in packages.fmus:
        assert word in read_model_description(fmu).description, fmu.name


def test_archive_is_plain(fmu: Path) -> None:
    with zipfile.ZipFile(fmu) as archive:
        entries = archive.infolist()
    names = [entry.filename for entry in entries]
    assert names == sorted(names)
    assert not [name for name in names if "\\" in name or name.startswith("/") or ".." in name]
    assert {entry.compress_type for entry in entries} <= {zipfile.ZIP_DEFLATED}
    assert len({entry.date_time for entry in entries}) == 1, "one fixed time"
    for entry in entries:
        mode = entry.external_attr >> 16
        assert mode & stat.S_IRUSR, entry.filename
        assert bool(mode & stat.S_IXUSR) == entry.filename.startswith("binaries/"), entry.filename


def test_carries_no_path_of_the_machine_that_made_it(fmu: Path) -> None:
    """No file, including the binaries, contains the builder's home, this folder, or that of cargo's packages."""
    packages = os.environ.get("CARGO_HOME", str(Path.home() / ".cargo"))
    folders = [str(Path.home()), str(ROOT), packages]
    with zipfile.ZipFile(fmu) as archive:
        for name in archive.namelist():
            content = archive.read(name)
            assert not re.search(b"|".join(re.escape(folder.encode()) for folder in folders), content), name


def test_the_three_guids_differ(packages: Packages) -> None:
    guids = sorted(read_model_description(fmu).guid for fmu in packages.fmus)
    assert all(one != other for one, other in pairwise(guids))
