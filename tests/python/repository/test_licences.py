"""The licences in the FMUs are those of the compiled crates."""

from __future__ import annotations

import struct
import zipfile

import licences
import pytest
from fly.package import Packages
from fly.stages import StageError

pytestmark = pytest.mark.change


@pytest.mark.parametrize("shipped", [licences.FMUS, licences.WHEEL], ids=["FMUs", "wheel"])
def test_the_committed_file_is_fresh(shipped: licences.Shipped) -> None:
    """`python3 run.py freeze` regenerates it."""
    assert shipped.file.read_text(encoding="utf-8") == licences.text(shipped)


def test_every_crate_can_be_shipped() -> None:
    found = licences.compiled_in(licences.FMUS)
    names = {package["name"] for package in found}
    assert {"nalgebra", "num-dual", "serde_json", "toml"} <= names
    assert not {"clarabel", "serde_derive", "zip"} & names, "neither solvers nor macros are compiled in"
    assert {licences.chosen(package, licences.FMUS.allowed) for package in found} <= {"MIT", "Apache-2.0"}


@pytest.mark.parametrize("licence", ["GPL-3.0-only", "LGPL-2.1", "MIT AND GPL-2.0", "", None])
def test_what_cannot_be_shipped_is_refused(licence: str | None) -> None:
    with pytest.raises(StageError, match=r"^viral .* only MIT,"):
        licences.chosen({"name": "viral", "version": "1.0.0", "license": licence}, licences.WHEEL.allowed)


def test_travels_in_every_fmu(packages: Packages) -> None:
    for fmu in packages.fmus:
        with zipfile.ZipFile(fmu) as archive:
            folder = "documentation/licenses/"
            assert archive.read(f"{folder}third_party.txt") == licences.FMUS.file.read_bytes()
            named = [f"{folder}{name}" for name in ("license.txt", "LICENSE-MIT", "LICENSE-APACHE")]
            assert set(named) <= set(archive.namelist())


def test_every_fmu_has_a_picture(packages: Packages) -> None:
    for fmu in packages.fmus:
        with zipfile.ZipFile(fmu) as archive:
            picture = archive.read("model.png")
        assert picture.startswith(b"\x89PNG\r\n\x1a\n")
        width, height = struct.unpack(">II", picture[16:24])
        assert width == height == 100
