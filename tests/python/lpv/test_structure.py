"""`squid lpv synth --structure`: static output feedback and controllers of a given order, with proofs."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from conftest import Run, kinds, named
from fly.stages import ROOT
from syrupy.assertion import SnapshotAssertion
from test_lpv import refused

pytestmark = pytest.mark.change

COMPLEIB = ROOT / "tests" / "cases" / "compleib"
SPRING = {
    "A": [[0, 1], [-2, -0.5]],
    "Bt": [[0], [-1]],
    "B1": [[0, 0], [1, 0]],
    "B2": [[0], [1]],
    "Ct": [[1, 0]],
    "Dtt": [[0]],
    "Dt1": [[0, 0]],
    "Dt2": [[0]],
    "C1": [[1, 0], [0, 0]],
    "D1t": [[0], [0]],
    "D11": [[0, 0], [0, 0]],
    "D12": [[0], [0.3]],
    "C2": [[1, 0]],
    "D2t": [[0]],
    "D21": [[0, 0.1]],
}


def problem(directory: Path, plant: dict[str, object], **more: object) -> Path:
    path = directory / "problem.json"
    path.write_text(json.dumps({"data": {"P": plant, "blocks": [1], **more}}), encoding="utf-8")
    return path


def test_static_output_feedback_is_proved(
    run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    case = COMPLEIB / "compleib_HE1.json"
    done = run_squid("lpv", "synth", case, "--structure", "static", "--out", tmp_path, "--json")
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["controller_states"] == 0
    assert 0.0736 < found["certified_gamma"] < 0.1556
    assert not found["least"]
    assert kinds(found)[-1] == "local_search"
    checked = run_squid("lpv", "check", case, tmp_path / "certificate.json")
    assert checked.returncode == 0, checked.stderr


def test_what_no_controller_beats_is_called_the_least(run_squid: Run) -> None:
    """Static output feedback of this aircraft is as good as any controller."""
    done = run_squid("lpv", "synth", COMPLEIB / "compleib_AC17.json", "--structure", "static", "--json")
    found = json.loads(done.stdout)
    assert found["least"] and found["gamma"] == pytest.approx(6.6124, rel=1e-4)
    assert found["gamma"] < found["certified_gamma"] < 1.01 * found["gamma"]


def test_more_states_gain_more(run_squid: Run, tmp_path: Path) -> None:
    path = problem(tmp_path, SPRING)
    gains = []
    for structure in ("static", "1", "2"):
        done = run_squid("lpv", "synth", path, "--structure", structure, "--json")
        assert done.returncode == 0, done.stderr
        gains.append(json.loads(done.stdout)["certified_gamma"])
    least = json.loads(run_squid("lpv", "synth", path, "--json").stdout)["gamma"]
    assert gains[0] > 1.02 * gains[1]
    assert gains[1] > 0.99 * gains[2] > 0.98 * least


@pytest.mark.parametrize("name", ["rate", "dt"])
def test_what_does_not_go_with_it_is_refused(
    run_squid: Run, tmp_path: Path, name: str, snapshot: SnapshotAssertion
) -> None:
    path = problem(tmp_path, SPRING, **{name: 0.1})
    done = run_squid("lpv", "synth", path, "--structure", "static", "--json")
    assert refused(done.returncode, json.loads(done.stdout), done.stderr) == (None, name)
    assert named(done.stderr, TMP=tmp_path) == snapshot


def test_a_wrong_structure_is_refused(run_squid: Run, tmp_path: Path) -> None:
    path = problem(tmp_path, SPRING)
    for arguments in (["--structure", "dynamic"], ["--structure", "1", "--reduce"]):
        assert run_squid("lpv", "synth", path, *arguments).returncode == 64
