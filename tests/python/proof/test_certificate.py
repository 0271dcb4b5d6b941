"""The shipped certificate: proved, refused after tampering, and required before packing."""

from __future__ import annotations

import json
import re
import shutil
import zipfile
from collections.abc import Callable
from pathlib import Path

import fmpy
import pytest
from claims import claim, robust_gain, without_limits, without_model_error
from conftest import PITCHING, SQUID, Run, masked, messages, named, refusal, rewritten
from fly.master import Slave
from fly.package import Packages
from syrupy.assertion import SnapshotAssertion

pytestmark = pytest.mark.change


def edited(package: Path, copy: Path, name: str, change: Callable[[dict], None]) -> Path:
    """Copy an FMU with one of its JSON resources changed."""

    def change_text(content: bytes) -> bytes:
        value = json.loads(content)
        change(value)
        return json.dumps(value).encode()

    return rewritten(package, copy, f"resources/{name}", change_text)


def test_shipped_controllers_are_proved(
    packages: Packages, run_squid: Run, snapshot: SnapshotAssertion
) -> None:
    """Both FMUs with the controller are proved, with the residual of the fit."""
    said = []
    for package in (packages.controller, packages.loop):
        done = run_squid("verify", package, timeout=10.0)
        assert done.returncode == 0, done.stderr
        proved = [line for line in done.stdout.splitlines() if line.startswith("PROVED: ")]
        assert "deg" not in " ".join(proved), "the scales of the controller are not verified"
        assert "measurable" not in done.stdout
        verbose = run_squid("verify", package, "--verbose", timeout=10.0).stdout.splitlines()
        more = [line for line in verbose if line not in done.stdout.splitlines()]
        said.append([masked(line) for line in proved + more])
    assert said[0] == said[1] and said[0] == snapshot


def test_plant_has_nothing_to_verify(squid: Packages, run_squid: Run, snapshot: SnapshotAssertion) -> None:
    """An FMU without controller is not reported as a failed proof."""
    done = run_squid("verify", squid.plant, "--json")
    refusal(done, "no_certificate")
    assert messages(done, OUT=squid.folder) == snapshot


@pytest.mark.parametrize("matrix", ["A", "By", "Dtt"])
def test_controller_that_is_not_the_proved_one(
    squid: Packages, run_squid: Run, tmp_path: Path, matrix: str, snapshot: SnapshotAssertion
) -> None:
    """One number of the controller changed in its last digits: the proof belongs to another controller."""

    def change(controller: dict) -> None:
        controller["lft"][matrix][0][0] = controller["lft"][matrix][0][0] * (1 + 1e-15) + 1e-300

    spoilt = edited(squid.controller, tmp_path / "spoilt.fmu", "controller.json", change)
    done = run_squid("verify", spoilt, "--json")
    refusal(done, "mismatch")
    assert messages(done, TMP=tmp_path) == snapshot


def test_bound_that_is_too_good(
    squid: Packages, run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """A lower gamma in both files is not proved, and the failure is named."""

    def lower(value: dict) -> None:
        if "claims" in value:
            claim(value, "gain")["gamma"] *= 0.9
        else:
            value["gamma"]["bound"] *= 0.9

    once = edited(squid.controller, tmp_path / "once.fmu", "certificate.json", lower)
    twice = edited(once, tmp_path / "twice.fmu", "controller.json", lower)
    done = run_squid("verify", once, "--json")
    refusal(done, "mismatch")
    assert messages(done, TMP=tmp_path) == snapshot
    done = run_squid("verify", twice, "--json")
    assert "pivot" in refusal(done, "unproved")["reason"]


def test_certificate_that_lost_the_residual(
    squid: Packages, run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """A certified FMU must cover the residual, and keeps its mark; otherwise the theorem is for the fit alone."""
    spoilt = edited(
        squid.controller,
        tmp_path / "spoilt.fmu",
        "certificate.json",
        without_model_error,
    )
    done = run_squid("verify", spoilt, "--json")
    refusal(done, "no_residual")
    assert messages(done, TMP=tmp_path) == snapshot(name="lost")

    def unmark(controller: dict) -> None:
        controller["gamma"]["certified"] = False

    unmarked = edited(spoilt, tmp_path / "unmarked.fmu", "controller.json", unmark)
    done = run_squid("verify", unmarked, "--json")
    refusal(done, "wrong_guid")
    assert messages(done, TMP=tmp_path) == snapshot(name="unmarked")
    with zipfile.ZipFile(spoilt) as package:
        package.extract("resources/certificate.json", tmp_path)
    done = run_squid("verify", tmp_path / "resources" / "certificate.json", "--verbose")
    assert done.returncode == 0 and masked(done.stdout) == snapshot(name="alone")


def test_certificate_without_residual_is_not_packed(
    run_squid: Run, stored_design: Path, snapshot: SnapshotAssertion
) -> None:
    """The mark 'certified' stands for the bound with the residual."""
    path = stored_design / "certificate.json"
    certificate = without_model_error(json.loads(path.read_text(encoding="utf-8")))
    path.write_text(json.dumps(certificate), encoding="utf-8")
    done = run_squid("package", SQUID, "--out", stored_design, "--json")
    refusal(done, "uncertified")
    assert messages(done, OUT=stored_design) == snapshot


def test_ball_that_leaves_the_vehicle_out_is_not_packed(
    run_squid: Run, stored_design: Path, snapshot: SnapshotAssertion
) -> None:
    """A smaller ball of models is proved more easily, but no longer contains the true linearisations."""
    path = stored_design / "certificate.json"
    certificate = json.loads(path.read_text(encoding="utf-8"))
    (error,) = certificate["errors"]
    error["E"] = [[0.9 * entry for entry in row] for row in error["E"]]
    path.write_text(json.dumps(certificate), encoding="utf-8")
    assert run_squid("verify", path).returncode == 0
    done = run_squid("package", SQUID, "--out", stored_design, "--json")
    refusal(done, "uncertified")
    assert "1.1111" in done.stderr and masked(messages(done, OUT=stored_design)) == snapshot
    assert not list(stored_design.glob("*.fmu"))


def test_design_without_proof_is_not_packed(
    run_squid: Run, quick_vehicle: Path, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """Without certificate nothing is written; the flag overrides this, and the FMU then says so."""
    vehicle, out = quick_vehicle, tmp_path / "out"
    assert run_squid("design", vehicle, "--no-advise", "--out", out).returncode == 0
    (out / "certificate.json").unlink()
    done = run_squid("package", vehicle, "--out", out, "--json")
    refusal(done, "uncertified")
    assert messages(done, TMP=tmp_path) == snapshot(name="refused")
    assert not list(out.glob("*.fmu"))
    done = run_squid("package", vehicle, "--out", out, "--allow-uncertified")
    assert done.returncode == 0 and "UNCERTIFIED" in done.stdout
    with zipfile.ZipFile(out / "squid_controller.fmu") as package:
        assert "not certified" in package.read("modelDescription.xml").decode()
        page = package.read("documentation/index.html").decode()
        assert re.findall(">(UNCERTIFIED.*?)<", masked(page)) == snapshot(name="page")
        assert "resources/certificate.json" not in package.namelist()


@pytest.mark.parametrize(
    ("file", "change", "key"),
    [
        ("controller.json", lambda c: c["actuators"][0].update(scale=3000.0), "actuators[0].scale"),
        (
            "controller.json",
            lambda c: c["controller_inputs"][0].update(scale=99.0),
            "controller_inputs[0].scale",
        ),
        (
            "controller.json",
            lambda c: [
                c["controller_inputs"][i].update(kind=k) for i, k in ((0, "measurement"), (2, "reference"))
            ],
            "controller_inputs[0].kind",
        ),
        ("controller.json", lambda c: c.update(reference_filter=9.0), "reference_filter"),
        ("controller.json", lambda c: c.update(sample_time=1.0), "sample_time"),
        (
            "controller.json",
            lambda c: c["trim"]["signals"]["pitch"].__setitem__(7, 1.0),
            "trim.signals.pitch[7]",
        ),
        (
            "controller.json",
            lambda c: c["envelope"]["pitch"]["range"].__setitem__(1, [0.6]),
            "envelope.pitch.range[1][0]",
        ),
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
    """The certificate contains the matrices; scales, trims and sample time follow from vehicle and design file."""
    out = tmp_path / "out"
    out.mkdir()
    for path in squid.controller.parent.glob("*.json"):
        shutil.copy(path, out)
    content = json.loads((out / file).read_text(encoding="utf-8"))
    change(content)
    (out / file).write_text(json.dumps(content), encoding="utf-8")
    done = run_squid("package", SQUID, "--out", out, "--json")
    assert f"{file}: `{key}`" in refusal(done, "uncertified")["reason"]
    assert not list(out.glob("*.fmu"))


def test_resources_edited_after_packing_are_not_verified(
    squid: Packages, run_squid: Run, tmp_path: Path
) -> None:
    """Thirty times the gain of the loop, in an FMU whose matrices are still those of the proof."""

    def amplify(controller: dict) -> None:
        for actuator in controller["actuators"]:
            actuator["scale"] *= 30

    other = edited(squid.loop, tmp_path / "other.fmu", "controller.json", amplify)
    refusal(run_squid("verify", other, "--json"), "wrong_guid")
    assert run_squid("verify", squid.loop).returncode == 0


def test_verify_against_the_vehicle(packages: Packages, run_squid: Run, snapshot: SnapshotAssertion) -> None:
    """With vehicle and design file everything that the FMU uses is recomputed."""
    of, other = (SQUID, PITCHING) if packages.vehicle == "squid" else (PITCHING, SQUID)
    certificate = packages.folder / "certificate.json"
    for file in (packages.controller, packages.loop, certificate):
        done = run_squid("verify", file, "--vehicle", of, "--json")
        assert done.returncode == 0 and json.loads(done.stdout)["status"] == "proved", done.stderr
    for file, key in ((packages.loop, "not_of_inputs"), (certificate, "wrong_plant")):
        done = run_squid("verify", file, "--vehicle", other, "--json")
        refusal(done, key)
        assert messages(done, OUT=packages.folder) == snapshot(name=key)
    assert run_squid("verify", packages.loop, "--design", "design").returncode == 64


def test_the_sampled_certificate_is_of_its_vehicle(
    stored_design: Path, run_squid: Run, snapshot: SnapshotAssertion
) -> None:
    """The plant at the ticks is recomputed; the controller next to the certificate must be that in it, to the bit."""
    file = stored_design / "sampled_certificate.json"
    about = []

    def verify(vehicle: Path) -> dict:
        done = run_squid("verify", file, "--vehicle", vehicle, "--json")
        found = json.loads(done.stdout)
        about.extend(named(line, OUT=stored_design) for line in found.get("about", ()))
        return found

    assert verify(SQUID)["status"] == "proved"
    assert verify(PITCHING)["key"] == "wrong_plant"
    beside = stored_design / "controller.json"
    controller = json.loads(beside.read_text(encoding="utf-8"))
    controller["lft"]["A"][0][0] *= 1 + 1e-15
    beside.write_text(json.dumps(controller), encoding="utf-8")
    found = verify(SQUID)
    assert found["key"] == "mismatch" and "matrix A" in found["reason"]
    beside.unlink()
    assert verify(SQUID)["status"] == "proved"
    assert about == snapshot


def amplify(controller: dict) -> None:
    """Multiply the gain of a measurement by fifty."""
    controller["controller_inputs"][0]["scale"] /= 50


def widen(controller: dict) -> None:
    """Claim an acceleration that the vehicle does not have."""
    limits = controller["envelope"]["speed"]["rate"]
    limits[1][0] *= 1.1


@pytest.mark.parametrize(
    ("change", "key"), [(amplify, "controller_inputs[0].scale"), (widen, "envelope.speed.rate[1][0]")]
)
def test_a_controller_changed_under_a_fitting_guid(
    squid: Packages,
    run_squid: Run,
    tmp_path: Path,
    capfd: pytest.CaptureFixture[str],
    change: Callable[[dict], None],
    key: str,
    snapshot: SnapshotAssertion,
) -> None:
    """Whoever changes a scale can change the GUID as well; the vehicle file reveals it."""
    spoilt = edited(squid.controller, tmp_path / "spoilt.fmu", "controller.json", change)
    with pytest.raises(Exception, match="instantiate"):
        Slave(spoilt, "spoilt")
    packed = fmpy.read_model_description(spoilt).guid
    (fitting,) = set(re.findall(r"\{[0-9a-f-]{36}\}", capfd.readouterr().out)) - {packed}
    forged = rewritten(
        spoilt,
        tmp_path / "forged.fmu",
        "modelDescription.xml",
        lambda xml: xml.replace(packed.encode(), fitting.encode()),
    )
    with Slave(forged, "forged") as slave:
        slave.begin()
        slave.ready()
    done = run_squid("verify", forged)
    assert done.returncode == 0, "the GUID is no signature"
    unverified = [line for line in done.stdout.splitlines() if line.startswith("not verified")]
    assert unverified == snapshot(name="unverified")
    done = run_squid("verify", forged, "--vehicle", SQUID, "--json")
    assert f"`{key}`" in refusal(done, "not_of_inputs")["reason"]
    assert masked(messages(done, TMP=tmp_path)) == snapshot(name="forged")


@pytest.mark.parametrize(
    "name", ["./resources/controller.json", "resources//controller.json", "resources/Controller.json"]
)
def test_an_archive_that_tools_unpack_differently(
    squid: Packages, run_squid: Run, tmp_path: Path, name: str
) -> None:
    """The proved controller must be the one in use, whichever of two entries a tool unpacks last."""
    spoilt = tmp_path / "spoilt.fmu"
    shutil.copy(squid.controller, spoilt)
    with zipfile.ZipFile(spoilt, "a") as package:
        package.writestr(name, "{}")
    done = run_squid("verify", spoilt, "--json")
    assert name.split("/")[-1] in refusal(done, "archive")["reason"]


def test_a_guid_beside_the_attribute_does_not_count(squid: Packages, run_squid: Run, tmp_path: Path) -> None:
    """If the attribute differs, the right GUID in a comment does not help."""
    guid = fmpy.read_model_description(squid.controller).guid.encode()

    def shift(xml: bytes) -> bytes:
        return xml.replace(guid, b"{other}") + b'<!-- guid="' + guid + b'" -->'

    spoilt = rewritten(squid.controller, tmp_path / "spoilt.fmu", "modelDescription.xml", shift)
    done = run_squid("verify", spoilt, "--json")
    refusal(done, "wrong_guid")


def test_a_description_edited_after_packing_is_not_verified(
    squid: Packages, run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """A tool that sends its start values would simulate another mass."""

    def burden(xml: bytes) -> bytes:
        heavier, count = re.subn(rb'(name="mass".*?start=")[0-9.]+', rb"\g<1>90.0", xml, count=1, flags=re.S)
        assert count == 1
        return heavier

    spoilt = rewritten(squid.loop, tmp_path / "spoilt.fmu", "modelDescription.xml", burden)
    done = run_squid("verify", spoilt, "--json")
    refusal(done, "wrong_description")
    assert messages(done, TMP=tmp_path) == snapshot


def test_what_is_no_fmu_is_told(
    squid: Packages, run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """An archive with another extension is read as one; every message names its file."""
    other = tmp_path / "controller.zip"
    shutil.copy(squid.controller, other)
    assert run_squid("verify", other).returncode == 0
    ssp = next(squid.controller.parent.glob("*.ssp"))
    done = run_squid("verify", ssp, "--json")
    refusal(done, "archive")
    assert messages(done, OUT=squid.folder) == snapshot
    reason = refusal(run_squid("verify", squid.folder / "design.json", "--json"), "certificate")["reason"]
    assert "design.json: " in reason and "`format`" in reason


def squid_design(squid: Packages, out: Path) -> tuple[dict, dict]:
    """Copy the design of Squid into a folder; return its certificate, without limits, and its controller."""
    out.mkdir()
    for path in squid.controller.parent.glob("*.json"):
        shutil.copy(path, out)
    names = ("certificate.json", "controller.json")
    certificate, controller = (json.loads((out / name).read_text(encoding="utf-8")) for name in names)
    return without_limits(certificate), controller


def zeros(rows: int, columns: int) -> list[list[float]]:
    """Return a matrix of zeros."""
    return [[0.0] * columns for _ in range(rows)]


def diagonal(values: list[float]) -> list[list[float]]:
    """Return a diagonal matrix."""
    return [[v if i == j else 0.0 for j in range(len(values))] for i, v in enumerate(values)]


def test_a_plant_that_overflows_is_not_this_plant(
    squid: Packages, run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """Channels of 1e157 without effect: a true theorem, but in floating point the plant overflows."""
    out = tmp_path / "out"
    certificate, controller = squid_design(squid, out)
    plant, law = certificate["plant"], certificate["controller"]
    n, w, z, u, y = (
        len(plant["A"]),
        len(plant["D11"][0]),
        len(plant["D11"]),
        len(plant["D12"][0]),
        len(plant["C2"]),
    )
    (r,), nk, rk = certificate["blocks"], len(law["A"]), len(law["Ct"])
    huge = zeros(r, r)
    huge[0][1] = huge[1][2] = 1e157
    sizes = {"x": n, "t": r, "w": w, "z": z, "u": u, "y": y}
    rows = {
        "A": "xx",
        "Bt": "xt",
        "B1": "xw",
        "B2": "xu",
        "Ct": "tx",
        "C1": "zx",
        "C2": "yx",
        "Dt1": "tw",
        "Dt2": "tu",
    }
    rows |= {"D1t": "zt", "D11": "zw", "D12": "zu", "D2t": "yt", "D21": "yw"}
    certificate["plant"] = {name: zeros(sizes[a], sizes[b]) for name, (a, b) in rows.items()}
    certificate["plant"] |= {"A": diagonal([-1000.0] * n), "Dtt": huge}
    law = {name: zeros(len(value), len(value[0])) for name, value in law.items()}
    law |= {"A": diagonal([-1.0] * nk), "Duy": [[3.0] * y for _ in range(u)]}
    certificate["controller"] = law
    controller["lft"] = {"blocks": controller["lft"]["blocks"], **law}
    proof = {"X": diagonal([1.0] * (n + nk)), "T": zeros(r + rk, r + rk)}
    proof |= {"S": diagonal([5e-324, 1e-9, 1e306] + [1.0] * (r - 3 + rk)), "gamma": 1e-6}
    certificate["errors"][0]["Fw"] = []
    claim(certificate, "gain").update(proof)
    robust_gain(certificate).update({**proof, "lambda": 1.0})
    controller["gamma"] |= {"bound": 1e-6, "optimum": 1e-6}
    for name, value in (("certificate.json", certificate), ("controller.json", controller)):
        (out / name).write_text(json.dumps(value), encoding="utf-8")
    done = run_squid("verify", out / "certificate.json")
    assert done.returncode == 0, f"the spoilt certificate is a true theorem: {done.stderr}"
    done = run_squid("package", SQUID, "--out", out, "--json")
    refusal(done, "uncertified")
    assert messages(done, TMP=tmp_path) == snapshot
    assert not list(out.glob("*.fmu"))


def test_a_ball_that_overflows_holds_nothing(
    squid: Packages, run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """An E so small that its inverse is infinite proves no more than the absence of a ball."""
    out = tmp_path / "out"
    certificate, _ = squid_design(squid, out)
    (ball,) = certificate["errors"]
    robust_gain(certificate).update({**claim(certificate, "gain"), "lambda": 1e-3})
    ball["E"] = [[1e-310 if i == j else 0.0 for j in range(len(row))] for i, row in enumerate(ball["E"])]
    for key in ("F", "Fw", "Fu"):
        ball[key] = [[1e-3 * (value != 0.0) for value in row] for row in ball[key]]
    (out / "certificate.json").write_text(json.dumps(certificate), encoding="utf-8")
    assert run_squid("verify", out / "certificate.json").returncode == 0
    done = run_squid("package", SQUID, "--out", out, "--json")
    refusal(done, "uncertified")
    assert messages(done, TMP=tmp_path) == snapshot


def test_blocks_of_nothing_are_refused(
    squid: Packages, run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """A first parameter without channels: no panic, one sentence."""
    out = tmp_path / "out"
    certificate, _ = squid_design(squid, out)
    certificate["blocks"].insert(0, 0)
    (out / "certificate.json").write_text(json.dumps(certificate), encoding="utf-8")
    done = run_squid("package", SQUID, "--out", out, "--json")
    refusal(done, "uncertified")
    assert masked(messages(done, TMP=tmp_path)) == snapshot


def test_certificate_of_another_design_is_not_packed(
    remus100: Packages, run_squid: Run, stored_design: Path, snapshot: SnapshotAssertion
) -> None:
    """A valid certificate of another controller does not help."""
    shutil.copy(remus100.controller.parent / "certificate.json", stored_design / "certificate.json")
    done = run_squid("package", SQUID, "--out", stored_design, "--json")
    refusal(done, "uncertified")
    assert messages(done, OUT=stored_design) == snapshot


def test_proof_of_another_plant_is_not_packed(
    run_squid: Run, stored_design: Path, snapshot: SnapshotAssertion
) -> None:
    """Outputs scaled down give a valid certificate, but not of this vehicle and these weights."""
    path = stored_design / "certificate.json"
    certificate = json.loads(path.read_text(encoding="utf-8"))
    for key in ("C1", "D1t", "D11", "D12"):
        rows = certificate["plant"][key]
        certificate["plant"][key] = [[value / 1024 for value in row] for row in rows]
    path.write_text(json.dumps(certificate), encoding="utf-8")
    assert run_squid("verify", path).returncode == 0, "the spoilt certificate is a true theorem"
    done = run_squid("package", SQUID, "--out", stored_design, "--json")
    refusal(done, "uncertified")
    assert messages(done, OUT=stored_design) == snapshot
