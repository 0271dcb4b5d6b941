"""`squid lpv` for plants in discrete time."""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from claims import claim
from conftest import Run, masked, messages, named
from fly.stages import ROOT
from syrupy.assertion import SnapshotAssertion
from test_lpv import refused, synth

pytestmark = pytest.mark.change

CASES = [
    ROOT / "tests" / "cases" / f"{name}.json" for name in ("hs02_gamma_sqrt065", "hs04_active_suspension")
]
STEP = 0.05
ONE = {"A": [[0.5]], "B1": [[1, 0]], "B2": [[1]], "C1": [[1], [0]], "D11": [[0, 0], [0, 0]], "D12": [[0], [1]],
       "C2": [[1]], "D21": [[0, 1]]}  # fmt: skip
SCHEDULED = {"P": ONE | {"Bt": [[1]], "Ct": [[1]], "Dtt": [[0]], "Dt1": [[0, 0]], "Dt2": [[0]], "D1t": [[0], [0]],
                         "D2t": [[0]]}, "blocks": [1]}  # fmt: skip


def discretised(data: dict, step: float) -> dict:
    """Return a plant discretised by the trapezoidal rule, scaled so that it keeps its least gamma."""
    part = {key: np.array(value, dtype=float) for key, value in data.items() if key != "G"}
    a, b = part["A"], np.hstack([part["B1"], part["B2"]])
    c = np.vstack([part["C1"], part["C2"]])
    nw, nz = part["B1"].shape[1], len(part["C1"])
    d22 = part.get("D22", np.zeros((len(part["C2"]), part["B2"].shape[1])))
    d = np.block([[part["D11"], part["D12"]], [part["D21"], d22]])
    one = np.eye(len(a))
    back = np.linalg.inv(one - 0.5 * step * a)
    f, g, h = back @ (one + 0.5 * step * a), back @ b * step, c @ back
    j = d + 0.5 * step * c @ back @ b
    cut = {"A": f, "B1": g[:, :nw], "B2": g[:, nw:], "C1": h[:nz], "C2": h[nz:]}
    cut |= {"D11": j[:nz, :nw], "D12": j[:nz, nw:], "D21": j[nz:, :nw], "D22": j[nz:, nw:]}
    return {key: value.tolist() for key, value in cut.items()} | {"dt": step}


def written(path: Path, data: dict) -> Path:
    """Write a problem file."""
    path.write_text(json.dumps({"data": data}), encoding="utf-8")
    return path


@pytest.mark.parametrize("case", CASES, ids=lambda path: path.stem)
def test_the_least_gamma_is_that_in_continuous_time(run_squid: Run, tmp_path: Path, case: Path) -> None:
    """For a published plant, the proof is for the matrices in the file, and eigenvalues confirm the inequality."""
    published = json.loads(case.read_text("utf-8"))
    problem = written(tmp_path / "p.json", discretised(published["data"], STEP))
    done = run_squid("--json", "lpv", "synth", problem, "--out", tmp_path / "out")
    report = json.loads(done.stdout)
    expected = published["expected"]
    assert report["gamma"] == pytest.approx(expected["gamma"], rel=expected["rtol"])
    assert report["gamma_lower"] is None
    certificate = tmp_path / "out" / "certificate.json"
    assert run_squid("lpv", "check", problem, certificate).returncode == 0
    held = json.loads(certificate.read_text("utf-8"))
    gain = claim(held, "gain")
    assert held["discrete"] is True and gain["gamma"] == report["certified_gamma"]
    a, b, c, d = closed(held["plant"], held["controller"])
    v, gamma = np.array(gain.get("V", [])), gain["gamma"]
    x = v.T @ v if "V" in gain else np.array(gain["X"])
    inner = np.block([[a, b], [c, d]])
    form = inner.T @ np.block(
        [[x, np.zeros((len(x), len(c)))], [np.zeros((len(c), len(x))), np.eye(len(c)) / gamma]]
    )
    form = form @ inner - np.block(
        [[x, np.zeros((len(x), b.shape[1]))], [np.zeros((b.shape[1], len(x))), gamma * np.eye(b.shape[1])]]
    )
    scale = 1.0 / np.sqrt(-np.diag(form))
    assert np.linalg.eigvalsh(scale[:, None] * form * scale).max() < 0.0
    assert np.abs(np.linalg.eigvals(a)).max() < 1.0


def closed(p: dict, k: dict) -> tuple[np.ndarray, ...]:
    """Return the loop of a plant and a controller without parameters, exact up to the last rounding."""
    p, k = ({key: exact(value) for key, value in parts.items()} for parts in (p, k))
    n, nk, ny, nu = len(p["A"]), len(k["A"]), len(p["C2"]), p["B2"].shape[1]
    d22 = p.get("D22", exact(np.zeros((ny, nu))))
    assert nu == ny == 1 or not d22.any()
    factor = 1 / (1 - (k["Duy"] @ d22)[0, 0])
    ux, uk, uw = factor * k["Duy"] @ p["C2"], factor * k["Cu"].reshape(nu, nk), factor * k["Duy"] @ p["D21"]
    yx, yk, yw = p["C2"] + d22 @ ux, d22 @ uk, p["D21"] + d22 @ uw
    a = np.block(
        [[p["A"] + p["B2"] @ ux, p["B2"] @ uk], [k["By"] @ yx, k["A"].reshape(nk, nk) + k["By"] @ yk]]
    )
    b = np.vstack([p["B1"] + p["B2"] @ uw, k["By"] @ yw])
    c, d = np.hstack([p["C1"] + p["D12"] @ ux, p["D12"] @ uk]), p["D11"] + p["D12"] @ uw
    assert a.shape == (n + nk, n + nk)
    return tuple(part.astype(float) for part in (a, b, c, d))


def exact(rows: list) -> np.ndarray:
    """Return rows as rational numbers."""
    return np.array([[Fraction(float(v)) for v in row] for row in rows], dtype=object)


def test_a_certificate_of_the_other_time_is_refused(
    run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """The matrices agree, and the kind of time differs."""
    discrete, continuous = written(tmp_path / "d.json", ONE | {"dt": 0.1}), written(tmp_path / "c.json", ONE)
    run_squid("lpv", "synth", discrete, "--out", tmp_path / "out")
    certificate = tmp_path / "out" / "certificate.json"
    done = run_squid("lpv", "check", discrete, certificate)
    assert done.returncode == 0 and masked(done.stdout) == snapshot(name="proved")
    done = run_squid("lpv", "check", continuous, certificate)
    assert done.returncode == 1 and messages(done, TMP=tmp_path) == snapshot(name="continuous")
    # A certificate is also a valid problem file.
    again = run_squid("--json", "lpv", "synth", certificate)
    assert json.loads(again.stdout)["gamma"] == pytest.approx(
        json.loads(run_squid("--json", "lpv", "synth", discrete).stdout)["gamma"], rel=1e-6
    )


@pytest.mark.parametrize(
    ("data", "line", "key"),
    [
        (ONE | {"dt": 0}, None, "dt"),
        (ONE | {"dt": True}, 1, "data.dt"),
        (SCHEDULED | {"rate": 1, "dt": 0.1}, None, "dt"),
        (
            {**ONE, "A": [[1, 0], [0, -1]], "B1": [[1, 0], [0, 1]], "B2": [[1], [1]], "C1": [[1, 0], [0, 0]],
             "C2": [[1, 1]], "dt": 1},
            None,
            "A",
        ),
    ],
)  # fmt: skip
def test_misuse(
    run_squid: Run, tmp_path: Path, data: dict, line: int | None, key: str, snapshot: SnapshotAssertion
) -> None:
    code, report, error = synth(run_squid, tmp_path / "p.json", {"data": data})
    assert refused(code, report, error) == (line, key)
    assert named(error, TMP=tmp_path) == snapshot
