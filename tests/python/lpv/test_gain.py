"""`squid lpv gain`: the gain of a finished loop, with its certificate."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from conftest import Run

PLANT = {"A": [[-2.0, -3.0], [1.0, 1.0]], "B1": [[1.0], [0.0]], "C1": [[1.0, 0.0]], "D11": [[0.0]]}


def demo(size: float) -> dict:
    """Return the plant of IQClab's Demo_001: one parameter, repeated twice, |delta| <= size."""
    channels = {
        "Bt": [[size, 0.0], [0.0, 0.0]],
        "Ct": [[1.0, 0.0], [0.0, 0.0]],
        "Dtt": [[size, -2.0 * size], [size, -size]],
        "Dt1": [[0.0], [1.0]],
        "D1t": [[0.0, size]],
    }
    return {"data": {"P": PLANT | channels, "blocks": [2]}}


def written(folder: Path, problem: dict) -> Path:
    """Write a problem file."""
    path = folder / "problem.json"
    path.write_text(json.dumps(problem), encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("size", "jumping", "constant"),
    [(0.1, 1.806857, 1.6171701), (0.3, 2.683535, 2.00650064), (0.5, 4.48476, 2.4546307)],
)
def test_published_gains(
    run_squid: Run, tmp_path: Path, size: float, jumping: float, constant: float
) -> None:
    """The least bound is met to 1e-4 and not passed, the worst constant parameter is found and bounded closely."""
    path = written(tmp_path, demo(size))
    done = run_squid("lpv", "gain", path, "--out", tmp_path, "--json")
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["status"] == "proved"
    assert jumping * (1.0 - 1e-6) <= found["gamma"] <= jumping * (1.0 + 1e-4)
    assert jumping < found["proved"] < 1.002 * jumping
    assert found["constant_lower"] == pytest.approx(constant, rel=1e-6)
    assert constant <= found["constant_upper"] < 1.001 * constant
    assert [abs(theta) for theta in found["constant_theta"]] == [1.0]
    checked = run_squid("verify", tmp_path / "certificate.json", "--json")
    assert checked.returncode == 0, checked.stderr
    certificate = json.loads((tmp_path / "certificate.json").read_text("utf-8"))
    assert len(certificate["X"]) == len(PLANT["A"]), "of the loop alone"


def test_a_bounded_rate_lies_between(run_squid: Run, tmp_path: Path) -> None:
    """Slower parameters have a smaller bound, above that of constant ones."""
    problem = demo(0.5)
    bounds = []
    for rate in (0.05, 1.0):
        problem["data"]["rate"] = rate
        found = json.loads(run_squid("lpv", "gain", written(tmp_path, problem), "--json").stdout)
        assert found["proved_at_rate"] <= found["proved"], found
        bounds.append(found["proved_at_rate"])
    assert 2.4546307 < bounds[0] < bounds[1] < 4.49


@pytest.mark.parametrize(
    ("change", "code", "words"),
    [
        ({"A": [[0.5, 0.0], [0.0, -1.0]]}, 3, "unstable"),
        ({"B2": [[1.0], [0.0]], "D12": [[1.0]], "Dt2": [[0.0], [0.0]]}, 1, "'B2' and others have 1 controls"),
        ({"C2": [[1.0, 0.0]], "D21": [[1.0]], "D2t": [[0.0, 0.0]]}, 1, "'C2' and others have 1 measurements"),
        ({"B1": None}, 1, "'B1'"),
    ],
)
def test_what_has_no_gain_is_refused(
    run_squid: Run, tmp_path: Path, change: dict, code: int, words: str
) -> None:
    problem = demo(0.1)
    problem["data"]["P"] |= change
    problem["data"]["P"] = {key: value for key, value in problem["data"]["P"].items() if value is not None}
    path = written(tmp_path, problem)
    done = run_squid("lpv", "gain", path, "--out", tmp_path, "--json")
    assert done.returncode == code, done.stdout
    assert words in done.stdout + done.stderr
    assert not (tmp_path / "certificate.json").exists()


@pytest.mark.parametrize(
    ("inside", "beside", "above", "words"),
    [
        ({"speed": 1}, {}, {}, "'speed' is not known (allowed in 'P': A, Bt, "),
        ({}, {"sped": 1}, {}, "'sped' is not known (allowed in 'data': blocks, rate, limits, dt, P, plant)"),
        ({}, {"rates": 1}, {}, "'rates' is not known; did you mean 'rate'?"),
        ({}, {}, {"speed": 1}, "'speed' is not known (allowed beside 'data': data)"),
        ({}, {}, {"rate": 1}, "'rate' is out of place; it stands in 'data'"),
    ],
)
def test_no_key_is_ignored(
    run_squid: Run, tmp_path: Path, inside: dict, beside: dict, above: dict, words: str
) -> None:
    """An unknown key is refused wherever it stands; what a file says of itself is not."""
    problem = demo(0.1) | {"kind": "lpvgain", "source": "IQClab", "notes": "none"} | above
    problem["data"] |= beside
    problem["data"]["P"] = problem["data"]["P"] | inside
    done = run_squid("lpv", "gain", written(tmp_path, problem), "--json")
    assert done.returncode == 1
    assert words in done.stderr and "problem.json: " in done.stderr


def test_a_plant_without_parameters_has_no_blocks(run_squid: Run, tmp_path: Path) -> None:
    """`blocks` beside plain matrices would be ignored, and is refused."""
    done = run_squid("lpv", "gain", written(tmp_path, {"data": PLANT | {"blocks": [1]}}), "--json")
    assert done.returncode == 1 and "'blocks' is out of place" in done.stderr
