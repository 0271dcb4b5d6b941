"""The certificate as shipped: proved, refused when tampered with, demanded before anything is packed."""

from __future__ import annotations

import json
import shutil
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest
from conftest import Run
from fly.package import Packages
from fly.stages import ROOT


def edited(package: Path, copy: Path, name: str, change: Callable[[dict], None]) -> Path:
    """Copy an FMU with one of its JSON resources changed."""
    with zipfile.ZipFile(package) as source, zipfile.ZipFile(copy, "w", zipfile.ZIP_DEFLATED) as target:
        for entry in source.infolist():
            content = source.read(entry)
            if entry.filename == f"resources/{name}":
                value = json.loads(content)
                change(value)
                content = json.dumps(value).encode()
            target.writestr(entry, content)
    return copy


def test_shipped_controllers_are_proved(packages: Packages, run_squid: Run) -> None:
    """Both FMUs that hold the controller prove, with the residual of the fit."""
    for package in (packages.controller, packages.loop):
        done = run_squid("verify", package, timeout=10.0)
        assert done.returncode == 0, done.stderr
        assert "PROVED: For every measurable trajectory" in done.stdout
        assert "when [A B2] of the plant is replaced" in done.stdout


def test_plant_has_nothing_to_verify(squid: Packages, run_squid: Run) -> None:
    """An FMU without controller is told apart from one that fails."""
    done = run_squid("verify", squid.plant)
    assert done.returncode == 1
    assert "nothing to verify" in done.stderr


@pytest.mark.parametrize("matrix", ["A", "By", "Dtt"])
def test_controller_that_is_not_the_proved_one(
    squid: Packages, run_squid: Run, tmp_path: Path, matrix: str
) -> None:
    """One number of the flown controller changed in its last digits: the proof is of another controller."""

    def change(controller: dict) -> None:
        controller["lft"][matrix][0][0] = controller["lft"][matrix][0][0] * (1 + 1e-15) + 1e-300

    done = run_squid("verify", edited(squid.controller, tmp_path / "spoilt.fmu", "controller.json", change))
    assert done.returncode == 1
    assert f"matrix {matrix} differs" in done.stderr


def test_bound_that_is_too_good(squid: Packages, run_squid: Run, tmp_path: Path) -> None:
    """A lower gamma in both files does not prove, and the failure is named."""

    def lower(value: dict) -> None:
        inner = value["gamma"] if isinstance(value["gamma"], dict) else None
        if inner is None:
            value["gamma"] *= 0.9
        else:
            inner["bound"] *= 0.9

    once = edited(squid.controller, tmp_path / "once.fmu", "certificate.json", lower)
    twice = edited(once, tmp_path / "twice.fmu", "controller.json", lower)
    assert "gamma differs" in run_squid("verify", once).stderr
    done = run_squid("verify", twice)
    assert done.returncode == 1
    assert "not proved" in done.stderr and "pivot" in done.stderr


def test_certificate_that_lost_the_residual(squid: Packages, run_squid: Run, tmp_path: Path) -> None:
    """A certified FMU must cover it, and keeps its mark; elsewhere the theorem is of the fit alone."""
    spoilt = edited(
        squid.controller, tmp_path / "spoilt.fmu", "certificate.json", lambda c: c.pop("residual")
    )
    done = run_squid("verify", spoilt)
    assert done.returncode == 1 and "no section 'residual'" in done.stderr and "PROVED" not in done.stdout

    def unmark(controller: dict) -> None:
        controller["gamma"]["certified"] = False

    done = run_squid("verify", edited(spoilt, tmp_path / "unmarked.fmu", "controller.json", unmark))
    assert done.returncode == 1 and "changed after it was packed" in done.stderr
    with zipfile.ZipFile(spoilt) as package:
        package.extract("resources/certificate.json", tmp_path)
    done = run_squid("verify", tmp_path / "resources" / "certificate.json")
    assert done.returncode == 0 and "Nothing is proved of a plant that differs" in done.stdout


def test_certificate_without_residual_is_not_packed(
    run_squid: Run, copied_vehicle: Path, tmp_path: Path
) -> None:
    """The mark 'certified' stands for the bound with the residual, too."""
    out = tmp_path / "out"
    assert run_squid("design", copied_vehicle, "--out", out).returncode == 0
    path = out / "certificate.json"
    certificate = json.loads(path.read_text(encoding="utf-8"))
    del certificate["residual"]
    path.write_text(json.dumps(certificate), encoding="utf-8")
    done = run_squid("package", copied_vehicle, "--out", out)
    assert done.returncode == 1 and "no section 'residual'" in done.stderr


def test_ball_that_leaves_the_vehicle_out_is_not_packed(
    run_squid: Run, copied_vehicle: Path, tmp_path: Path
) -> None:
    """A smaller ball of models proves all the more, but it no longer holds the true linearisations."""
    out = tmp_path / "out"
    assert run_squid("design", copied_vehicle, "--out", out).returncode == 0
    path = out / "certificate.json"
    certificate = json.loads(path.read_text(encoding="utf-8"))
    residual = certificate["residual"]
    residual["E"] = [[0.9 * entry for entry in row] for row in residual["E"]]
    path.write_text(json.dumps(certificate), encoding="utf-8")
    assert run_squid("verify", path).returncode == 0
    done = run_squid("package", copied_vehicle, "--out", out)
    assert done.returncode == 1 and "reach 1.1111 times as far from the fit as the ball" in done.stderr
    assert not list(out.glob("*.fmu"))


def test_design_without_proof_is_not_packed(
    squid: Packages, run_squid: Run, copied_vehicle: Path, tmp_path: Path
) -> None:
    """Without certificate nothing is written; the flag overrides, and the FMU then says so."""
    out = tmp_path / "out"
    assert run_squid("design", copied_vehicle, "--out", out).returncode == 0
    (out / "certificate.json").unlink()
    done = run_squid("package", copied_vehicle, "--out", out)
    assert done.returncode == 1
    assert "not certified" in done.stderr and "--allow-uncertified" in done.stderr
    assert not list(out.glob("*.fmu"))
    done = run_squid("package", copied_vehicle, "--out", out, "--allow-uncertified")
    assert done.returncode == 0 and "UNCERTIFIED" in done.stdout
    with zipfile.ZipFile(out / "squid_controller.fmu") as package:
        assert "not certified" in package.read("modelDescription.xml").decode()
        assert "resources/certificate.json" not in package.namelist()


@pytest.mark.parametrize(
    ("file", "change", "key"),
    [
        ("controller.json", lambda c: c["actuators"][0].update(scale=3000.0), "actuators[0].scale"),
        ("controller.json", lambda c: c["tracked"][0].update(scale=99.0), "tracked[0].scale"),
        ("controller.json", lambda c: c.update(sample_time=1.0), "sample_time"),
        ("controller.json", lambda c: c["trim"]["pitch"].__setitem__(7, 1.0), "trim.pitch[7]"),
        ("plant.json", lambda p: p["a"][0][0].__setitem__(0, -9.0), "a[0][0][0]"),
    ],
)
def test_numbers_beside_the_proof_are_not_packed_when_edited(
    squid: Packages,
    run_squid: Run,
    tmp_path: Path,
    file: str,
    change: Callable[[dict], None],
    key: str,
) -> None:
    """The certificate holds the matrices; scales, trims and sample time follow from vehicle and design file."""
    out = tmp_path / "out"
    out.mkdir()
    for path in squid.controller.parent.glob("*.json"):
        shutil.copy(path, out)
    content = json.loads((out / file).read_text(encoding="utf-8"))
    change(content)
    (out / file).write_text(json.dumps(content), encoding="utf-8")
    done = run_squid("package", ROOT / "vehicles" / "squid", "--out", out)
    assert done.returncode == 1 and f"{file}: `{key}` is" in done.stderr
    assert not list(out.glob("*.fmu"))


def test_resources_edited_after_packing_are_not_verified(
    squid: Packages, run_squid: Run, tmp_path: Path
) -> None:
    """Thirty times the gain of the loop, in an FMU whose matrices are still those of the proof."""

    def amplify(controller: dict) -> None:
        for actuator in controller["actuators"]:
            actuator["scale"] *= 30

    done = run_squid("verify", edited(squid.loop, tmp_path / "other.fmu", "controller.json", amplify))
    assert done.returncode == 1 and "its resources were changed after it was packed" in done.stderr
    assert "PROVED" not in done.stdout
    assert run_squid("verify", squid.loop).returncode == 0


def test_certificate_of_another_design_is_not_packed(
    remus100: Packages, run_squid: Run, copied_vehicle: Path, tmp_path: Path
) -> None:
    """A certificate that proves, but for another controller, does not help."""
    out = tmp_path / "out"
    assert run_squid("design", copied_vehicle, "--out", out).returncode == 0
    shutil.copy(remus100.controller.parent / "certificate.json", out / "certificate.json")
    done = run_squid("package", copied_vehicle, "--out", out)
    assert done.returncode == 1 and "not of this controller" in done.stderr


def test_proof_of_another_plant_is_not_packed(run_squid: Run, copied_vehicle: Path, tmp_path: Path) -> None:
    """Outputs made small make a certificate that proves; but it is not of this vehicle and these weights."""
    out = tmp_path / "out"
    assert run_squid("design", copied_vehicle, "--out", out).returncode == 0
    path = out / "certificate.json"
    certificate = json.loads(path.read_text(encoding="utf-8"))
    for key in ("C1", "D1t", "D11", "D12"):
        rows = certificate["plant"][key]
        certificate["plant"][key] = [[value / 1024 for value in row] for row in rows]
    path.write_text(json.dumps(certificate), encoding="utf-8")
    assert run_squid("verify", path).returncode == 0, "the spoilt certificate is a true theorem"
    done = run_squid("package", copied_vehicle, "--out", out)
    assert done.returncode == 1 and "not of this plant" in done.stderr
