"""`squid lpv`: synthesis for any plant in a file, its three outcomes, and wrong files."""

from __future__ import annotations

import copy
import json
from pathlib import Path

import pytest
from conftest import Run
from fly.stages import ROOT

CASE = ROOT / "tests" / "cases" / "lpv05_one_param_lossless.json"


@pytest.fixture
def case() -> dict:
    """Return a problem that may be spoilt."""
    return copy.deepcopy(json.loads(CASE.read_text(encoding="utf-8")))


def synth(run_squid: Run, path: Path, value: dict | str, *options: str) -> tuple[int, dict, str]:
    """Run `squid lpv synth --json` on a problem; return exit code, report and standard error."""
    path.write_text(value if isinstance(value, str) else json.dumps(value), encoding="utf-8")
    done = run_squid("lpv", "synth", path, "--json", *options)
    report = json.loads(done.stdout) if done.stdout else {}
    return done.returncode, report, done.stderr


def test_files_and_check(run_squid: Run, tmp_path: Path) -> None:
    """The controller and the certificate are written, and the certificate proves for this plant alone."""
    done = run_squid("lpv", "synth", CASE, "--out", tmp_path)
    assert done.returncode == 0 and "PROVED" in done.stdout
    assert {path.name for path in tmp_path.iterdir()} == {
        "report.json",
        "controller.json",
        "certificate.json",
    }
    assert run_squid("lpv", "check", CASE, tmp_path / "certificate.json").returncode == 0
    assert run_squid("verify", tmp_path / "certificate.json").returncode == 0
    other = CASE.with_name("lpv01_lpvtools_lft_tutorial.json")
    done = run_squid("lpv", "check", other, tmp_path / "certificate.json")
    assert done.returncode == 1 and "not of this plant" in done.stderr


def test_units_do_not_change_the_answer(run_squid: Run, tmp_path: Path, case: dict) -> None:
    """States in other units, time in other units, channels in other units: the same gamma."""
    plain = synth(run_squid, tmp_path / "plain.json", case)[1]
    p = case["data"]["P"]
    states, speed, channel = [1e3, 1e-2, 5.0], 40.0, [1e2, 1e-3]
    p["A"] = [[v * speed * states[i] / states[j] for j, v in enumerate(row)] for i, row in enumerate(p["A"])]
    for key in ("B1", "B2", "Bt"):
        p[key] = [[v * speed * states[i] for v in row] for i, row in enumerate(p[key])]
    for key in ("C1", "C2", "Ct"):
        p[key] = [[v / states[j] for j, v in enumerate(row)] for row in p[key]]
    p["Bt"] = [[v * channel[j] for j, v in enumerate(row)] for row in p["Bt"]]
    p["Ct"] = [[v / channel[i] for v in row] for i, row in enumerate(p["Ct"])]
    scaled = synth(run_squid, tmp_path / "scaled.json", case)[1]
    assert scaled["status"] == "feasible"
    assert scaled["gamma"] == pytest.approx(plain["gamma"], rel=1e-5)
    assert scaled["gamma_symmetric"] == pytest.approx(plain["gamma_symmetric"], rel=1e-5)


def test_mode_that_cannot_be_stabilised(run_squid: Run, tmp_path: Path, case: dict) -> None:
    """An unstable mode that no control reaches is named."""
    case["data"]["P"]["A"][2] = [0.0, 0.0, 0.5]
    code, report, _ = synth(run_squid, tmp_path / "p.json", case)
    assert (code, report["status"]) == (2, "infeasible")
    assert "0.5000" in report["reason"] and "not reached by any control input" in report["reason"]
    assert report["gamma"] is None and report["certified_gamma"] is None


def test_mode_that_cannot_be_seen(run_squid: Run, tmp_path: Path, case: dict) -> None:
    """An unstable mode that no measurement shows is named."""
    p = case["data"]["P"]
    p["A"][2] = [0.0, 0.0, 0.25]
    p["B2"][2] = [1.0]
    code, report, _ = synth(run_squid, tmp_path / "p.json", case)
    assert (code, report["status"]) == (2, "infeasible")
    assert "0.2500" in report["reason"] and "not seen in any measurement" in report["reason"]


def test_parameter_that_no_controller_tames(run_squid: Run, tmp_path: Path, case: dict) -> None:
    """An unstable part that only the parameter drives, beyond any controller: provably infeasible."""
    p = case["data"]["P"]
    # The third state gets the pole -0.5 + theta, out of reach of the control.
    p["Bt"][2] = [1.0, 0.0]
    p["Ct"][0] = [0.0, 0.0, 1.0]
    p["Bt"][0] = p["Bt"][1] = [0.0, 0.0]
    code, report, _ = synth(run_squid, tmp_path / "p.json", case)
    assert (code, report["status"]) == (2, "infeasible"), report
    assert "every course of the parameters" in report["reason"]


def test_gamma_above_the_limit(run_squid: Run, tmp_path: Path, case: dict) -> None:
    """The limit is missed by how much, and on which path."""
    code, report, _ = synth(run_squid, tmp_path / "p.json", case, "--gamma-limit", "1.5")
    assert (code, report["status"]) == (2, "infeasible")
    assert "above the limit 1.5000" in report["reason"] and "path from w" in report["reason"]
    assert report["gamma"] == pytest.approx(2.0354532, rel=1e-5)


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (lambda c: c["data"]["P"].pop("B2"), "'B2' is missing"),
        (lambda c: c["data"]["P"]["A"][0].pop(), "'A' has rows of unlike length"),
        (lambda c: c["data"]["P"].update(C1="x"), "'C1' must be a list of rows of numbers"),
        (lambda c: c["data"].update(blocks=[3]), "must be"),
        (lambda c: c["data"].update(blocks=[-1]), "'blocks'"),
        (lambda c: c["data"]["P"]["B1"].pop(), "B1"),
    ],
)
def test_wrong_file(run_squid: Run, tmp_path: Path, case: dict, spoil, words: str) -> None:
    """A wrong file is refused with one sentence, and no report."""
    spoil(case)
    code, report, error = synth(run_squid, tmp_path / "p.json", case)
    assert code == 1 and report == {}
    assert words in error and len(error.strip().splitlines()) == 1


def test_not_json(run_squid: Run, tmp_path: Path) -> None:
    """Text that is no JSON is refused with file, line and column."""
    code, _, error = synth(run_squid, tmp_path / "p.json", '{"data": [}')
    assert code == 1 and "p.json" in error and "line 1" in error
