"""A vehicle without declared uncertainty, and the robust controller of one with uncertain coefficients."""

from __future__ import annotations

import json
import math
import re
import shutil
from pathlib import Path

import pytest
from claims import claim
from conftest import PITCHING, Run, designed, masked, messages, package, refusal, report_in
from fly.stages import ROOT
from syrupy.assertion import SnapshotAssertion

pytestmark = pytest.mark.change


def test_a_vehicle_without_uncertainty(
    run_squid: Run, quick_vehicle: Path, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """Design, report and package succeed; requests for uncertainty are refused, and nothing is written."""
    packages = package(run_squid, quick_vehicle, tmp_path / "out")
    done = run_squid("report", quick_vehicle, "--out", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    mu = page.partition('<section id="mu">')[2].partition("</section>")[0]
    assert re.findall("<p>(.*?)</p>", mu) == snapshot
    assert set((tmp_path / "out").glob("*.fmu")) == set(packages.fmus)
    for verb in (("show", "--uncertainty"), ("design", "--robust", "--out", tmp_path / "none")):
        done = run_squid(verb[0], quick_vehicle, *verb[1:], "--json")
        refusal(done, "nothing_uncertain")
    assert messages(done) == snapshot
    assert not (tmp_path / "none").exists()


def test_gains_of_actuators_alone(run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion) -> None:
    """Uncertain gains as declared by a design of `squid tune`: none is dropped; without any, nothing is claimed."""
    vehicle = Path(shutil.copytree(PITCHING, tmp_path / "remus100", ignore=shutil.ignore_patterns("frozen")))
    file = vehicle / "design.toml"
    design = file.read_text(encoding="utf-8").split("\n[uncertainty]\n")[0]
    file.write_text(f"{design}\n[uncertainty]\nactuator_gain = 0.05\n", encoding="utf-8")
    done = run_squid("design", vehicle, "--robust", "--out", tmp_path / "out", timeout=300.0)
    assert done.returncode == 0, done.stderr
    (kept,) = re.findall(r"^uncertain +2 .*", done.stdout, re.MULTILINE)
    assert "left out" not in kept
    file.write_text(f"{design}\n[uncertainty]\nactuator_gain = 0.001\n", encoding="utf-8")
    done = run_squid("design", vehicle, "--robust", "--out", tmp_path / "none", "--json", timeout=300.0)
    refusal(done, "nothing_left")
    assert masked(messages(done)) == snapshot
    assert not (tmp_path / "none").exists()


@pytest.mark.night
def test_the_robust_controller_tolerates_more(run_squid: Run, tmp_path: Path) -> None:
    """The robust controller tolerates more at the same gain, proved; a nominal design removes its files."""
    made = designed(run_squid, PITCHING, "--robust")
    found = json.loads((made / "robust.json").read_text(encoding="utf-8"))
    assert found["robust_tolerated_fraction"] > 1.15 * found["nominal_tolerated_fraction"] > 0.0
    certificate = made / "robust_certificate.json"
    proved = json.loads(certificate.read_text(encoding="utf-8"))
    assert len(proved["blocks"]) == 1 + found["sizes"][0], "rho and the uncertain parameters"
    assert len(proved["controller_blocks"]) == 1, "the controller knows rho alone"
    assert claim(proved, "gain")["gamma"] == found["proved"] <= found["gamma"], (
        "what is proved is what was allowed"
    )
    done = run_squid("verify", certificate)
    assert (done.returncode, "PROVED" in done.stdout) == (0, True)
    done = run_squid("verify", certificate, "--vehicle", PITCHING)
    assert done.returncode == 0, done.stderr
    tolerated = 100 * found["robust_tolerated_fraction"]
    for part in (f" {tolerated:.1f} % ", "Z_uq", "X_uu", str(PITCHING), "controller.json"):
        assert part in done.stdout
    for size, nominal, robust in found["ladder"][1:]:
        assert robust < (math.inf if nominal is None else nominal), size
    assert_documented(found)
    page = (
        report_in(run_squid, PITCHING, made).partition('<section id="robust">')[2].partition("</section>")[0]
    )
    assert f" {math.ceil(1e4 * found['proved']) / 1e4:.4f}" in page.replace("\u00a0", " ")
    copy = Path(shutil.copytree(made, tmp_path / "out"))
    done = run_squid("show", PITCHING, "--controller", "--out", copy)
    bound = json.loads((copy / "controller.json").read_text(encoding="utf-8"))["gamma"]["bound"]
    assert "--robust" in done.stdout and f" {math.ceil(1e4 * bound) / 1e4:.4f}" in done.stdout
    assert run_squid("design", PITCHING, "--no-advise", "--out", copy).returncode == 0
    assert not list(copy.glob("robust*"))


def assert_documented(found: dict) -> None:
    """Assert that docs/robust.md has these numbers of REMUS 100.

    The tolerance is 1 %; 5 % for the robust controller frozen at a speed: an alternating search ends elsewhere when
    rounding differs, by up to 3 % in the worst-case gain between two versions of the solver.
    """
    page = (ROOT / "docs" / "robust.md").read_text(encoding="utf-8")
    summary = next(line for line in page.splitlines() if line.startswith("| REMUS 100 | "))
    gamma, nominal, robust, ratio, proved, *gains = (
        float(cell.strip(" %")) for cell in summary.strip("|").split("|")[1:]
    )
    assert gamma == pytest.approx(found["gamma"], rel=0.01)
    assert [nominal, robust] == pytest.approx(
        [100 * found["nominal_tolerated_fraction"], 100 * found["robust_tolerated_fraction"]], rel=0.02
    )
    assert ratio == pytest.approx(robust / nominal, rel=0.02)
    assert proved == pytest.approx(found["proved"], rel=0.01)
    assert gains == pytest.approx(found["ladder"][0][1:], rel=0.01)
    mu, worst = page.split("| REMUS 100, m/s |")[1:]
    for table, of in ((mu, lambda f, i: f["mu"][i]), (worst, lambda f, i: f["worst"][i][0])):
        speeds, _, *rows = [
            [float(c) for c in re.findall(r"\d+\.\d+", line)] for line in table.splitlines()[:4]
        ]
        assert speeds == pytest.approx([f["speed"] for f in found["frozen"]], rel=0.01)
        for i, (row, tolerance) in enumerate(zip(rows, (0.01, 0.05), strict=True)):
            assert row == pytest.approx([of(f, i) for f in found["frozen"]], rel=tolerance)
    least, most = (f"{100 * part:.1f}" for part in found["remainder"])
    left_out = f"and {least} to {most} % for REMUS 100"
    assert left_out in page
