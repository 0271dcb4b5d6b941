"""Synthesis, gains and mu of general plants in Python: published cases, agreement with the command, misuse."""

from __future__ import annotations

import json
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from conftest import Run, masked
from fly.stages import ROOT
from syrupy.assertion import SnapshotAssertion
from test_inputs import reasons

pytestmark = pytest.mark.change

CASES = ROOT / "tests" / "cases"
NORMS = sorted(
    path for path in CASES.glob("*.json") if '"kind": "hinfsyn"' in path.read_text(encoding="utf-8")
)
TOLERANCE = 1e-9
"""Relative: how near a norm is computed."""


def plant(sq: ModuleType, data: dict, dt: float = 0.0) -> tuple:
    """Return a generalised plant with its numbers of measurements and controls."""
    parts = {key: np.array(value, dtype=float) for key, value in data.items() if key != "G"}
    d22 = np.zeros((len(parts["C2"]), parts["B2"].shape[1]))
    d = np.block([[parts["D11"], parts["D12"]], [parts["D21"], parts.get("D22", d22)]])
    b, c = np.hstack([parts["B1"], parts["B2"]]), np.vstack([parts["C1"], parts["C2"]])
    return sq.StateSpace(parts["A"], b, c, d, dt), len(parts["C2"]), parts["B2"].shape[1]


def spring(sq: ModuleType, **changed: object) -> tuple:
    """Return a mass on a spring, with a disturbance of its force and noise of its position."""
    data = {
        "A": [[0, 1], [-2, -0.5]], "B1": [[0, 0], [1, 0]], "B2": [[0], [1]], "C1": [[1, 0], [0, 0]],
        "D11": [[0, 0], [0, 0]], "D12": [[0], [0.3]], "C2": [[1, 0]], "D21": [[0, 0.1]],
    }  # fmt: skip
    return plant(sq, data | changed)


@pytest.mark.parametrize("path", NORMS, ids=lambda path: path.stem)
def test_published_norms(sq: ModuleType, run_squid: Run, tmp_path: Path, path: Path) -> None:
    """The least gamma is the published one, the proved gain is a bound, and both are those of the command line."""
    case = json.loads(path.read_text(encoding="utf-8"))
    found = sq.hinfsyn_proved(*plant(sq, case["data"]))
    expected = case["expected"]
    assert found.gamma == pytest.approx(expected["gamma"], rel=expected["rtol"])
    K, CL, gam, rcond = found.synthesis
    assert sq.hinfnorm(CL)[0] <= gam * (1.0 + TOLERANCE)
    assert found.certificate.verify().gamma == gam
    assert len(rcond) == 4 and len(K.A) <= len(case["data"]["A"])
    done = json.loads(run_squid("--json", "lpv", "synth", path).stdout)
    assert (found.gamma, gam) == (done["gamma"], done["certified_gamma"])


def test_systems_of_python_control(sq: ModuleType) -> None:
    """Each system type is accepted and returned, in continuous and discrete time; python-control agrees on the loop."""
    import control

    P, nmeas, ncon = spring(sq)
    for a, b, dt in ((P.A, P.B, 0.0), (np.eye(2) + 0.1 * P.A, 0.1 * P.B, 0.1)):
        given = control.ss(a, b, P.C, P.D, dt)
        K, CL, gam, _ = sq.hinfsyn(given, nmeas, ncon)
        assert isinstance(K, control.StateSpace) and K.dt == CL.dt == dt
        closed = given.lft(K)
        for omega in (0.1, 1.3, 10.0):
            at = np.exp(1j * omega * dt) if dt else 1j * omega
            assert CL(at) == pytest.approx(closed(at), rel=1e-9, abs=1e-12)
            assert np.linalg.norm(closed(at), 2) < gam


def test_a_direct_path_from_u_to_y(sq: ModuleType) -> None:
    without, _, gam, _ = sq.hinfsyn(*spring(sq))
    k, loop, with_gam, _ = sq.hinfsyn(*spring(sq, D22=[[0.5]]))
    assert with_gam == pytest.approx(gam, rel=1e-6)
    assert sq.hinfnorm(loop)[0] <= with_gam * (1.0 + TOLERANCE)
    assert not np.allclose(k.A, without.A)


@pytest.mark.parametrize(
    "a", [[[0.98, 0.1], [-0.2, 0.93]], [[1.0, 0.1], [0.0, 0.9]], [[-1.0, 0.1], [0.0, 0.9]]]
)
def test_discrete_time(sq: ModuleType, a: list) -> None:
    """The bound holds on the unit circle, also for poles at z = 1 and z = -1, and the proof is for these matrices."""
    P, nmeas, ncon = spring(sq, A=a)
    P = sq.StateSpace(P.A, 0.1 * P.B, P.C, P.D, 0.1)
    found = sq.hinfsyn_proved(P, nmeas, ncon)
    K, CL, gam, _ = found.synthesis
    theorem, held = found.certificate.verify(), json.loads(found.certificate.text)
    assert theorem.gamma == gam
    assert (held["plant"]["A"], held["controller"]["A"]) == (P.A.tolist(), K.A.tolist())
    assert (held["plant"]["D12"], held["controller"]["Duy"]) == (P.D[:2, 2:].tolist(), K.D.tolist())
    assert K.dt == CL.dt == 0.1 and np.abs(CL.poles()).max() < 1.0
    gains = [np.linalg.norm(CL(np.exp(1j * angle)), 2) for angle in np.linspace(0.0, np.pi, 4001)]
    norm, frequency = sq.hinfnorm(CL)
    assert max(gains) <= norm * (1.0 + TOLERANCE) and norm <= gam
    assert np.linalg.norm(CL(np.exp(0.1j * frequency)), 2) == pytest.approx(norm, rel=1e-6)


def test_a_sample_time_that_is_not_known(sq: ModuleType) -> None:
    """An unspecified sample time is preserved; the gain does not depend on it."""
    P, nmeas, ncon = spring(sq, A=[[0.98, 0.1], [-0.2, 0.93]])
    unknown, one = (
        sq.hinfsyn(sq.StateSpace(P.A, 0.1 * P.B, P.C, P.D, dt), nmeas, ncon) for dt in (True, 1.0)
    )
    assert unknown.K.dt is True and unknown.CL.dt is True
    assert unknown.gam == one.gam


def test_input_that_does_not_fit(sq: ModuleType, snapshot: SnapshotAssertion) -> None:
    P, _, _ = spring(sq)
    poles = sq.StateSpace(np.diag([1.0, -1.0]), P.B, P.C, P.D, 1.0)
    calls = {
        "sample time": lambda: sq.hinfsyn(sq.StateSpace(P.A, P.B, P.C, P.D, -1.0), 1, 1),
        "blocks": lambda: sq.mu(np.eye(2), [[1.5, 0], [1, 0]]),
        "poles at both ends of the circle": lambda: sq.hinfsyn(poles, 1, 1),
        "columns": lambda: sq.hinfsyn((P.A, P.B[:, :2], P.C, P.D), 1, 1),
        "key": lambda: sq.lpvsyn({"B7": [[1]]}, [1]),
        "rows of blocks": lambda: sq.musyn(P, 1, 1, [[1, 0]]),
    }
    assert reasons(sq.InputError, calls) == snapshot


def test_there_and_back_by_mat(sq: ModuleType, tmp_path: Path) -> None:
    """A file with MATLAB's names: SciPy alone reads it, and a plant is restored unchanged."""
    from scipy.io import loadmat, savemat

    P, nmeas, ncon = spring(sq)
    savemat(
        tmp_path / "p.mat", {"P": dict(zip("abcd", (P.A, P.B, P.C, P.D), strict=True)), "nmeas": 1, "ncon": 1}
    )
    read = sq.loadmat(tmp_path / "p.mat")
    assert read[1:] == (nmeas, ncon)
    assert all(np.array_equal(getattr(read[0], part), getattr(P, part)) for part in "ABCD")
    found = sq.hinfsyn(P, nmeas, ncon)
    sq.savemat(tmp_path / "k.mat", found)
    held = loadmat(tmp_path / "k.mat", simplify_cells=True)
    assert np.array_equal(held["K"]["a"], found.K.A) and held["gam"] == found.gam
    with pytest.raises(sq.InputError, match="'nmeas' is missing"):
        sq.loadmat(tmp_path / "k.mat", "K")


def test_a_scheduled_controller(sq: ModuleType, snapshot: SnapshotAssertion) -> None:
    """The tutorial of LPVTools: the least gamma is the published one, and frozen loops stay below the proved gain."""
    case = json.loads((CASES / "lpv01_lpvtools_lft_tutorial.json").read_text(encoding="utf-8"))
    P = {key: value for key, value in case["data"]["P"].items() if key in sq.synthesis.PLANT}
    found = sq.lpvsyn(P, case["data"]["blocks"])
    assert found.gamma == pytest.approx(case["expected"]["gamma_opt"], rel=case["expected"]["rtol"])
    assert found.certificate.verify().gamma == found.gam
    assert found.K.frozen(0.5).A.shape == found.K.frozen(-1.0).A.shape
    calls = {"two": lambda: found.K.frozen(0.0, 0.0), "beyond": lambda: found.K.frozen(1.5)}
    assert reasons(sq.InputError, calls) == snapshot


def test_a_scheduled_controller_in_discrete_time(sq: ModuleType, snapshot: SnapshotAssertion) -> None:
    """A spring whose parameter jumps at random: no simulation has a gain above the proved one."""
    P = {
        "A": [[1, 0.1], [-0.2, 0.95]], "Bt": [[0], [-0.1]], "B1": [[0, 0], [0.1, 0]], "B2": [[0], [0.1]],
        "Ct": [[1, 0]], "C1": [[1, 0], [0, 0]], "D11": np.zeros((2, 2)), "D12": [[0], [0.3]], "C2": [[1, 0]],
        "D21": [[0, 0.1]], "Dtt": [[0]], "Dt1": [[0, 0]], "Dt2": [[0]], "D1t": [[0], [0]], "D2t": [[0]],
    }  # fmt: skip
    found = sq.lpvsyn(P, [1], dt=0.1)
    theorem = found.certificate.verify()
    assert theorem.gamma == found.gam and masked(theorem.claim) == snapshot
    p = {key: np.array(value, dtype=float) for key, value in P.items()}
    rng = np.random.default_rng(5)
    for jumps in (1, 7, 200):
        x, xk, energy = np.zeros(2), np.zeros(len(found.K.matrices["A"])), np.zeros(2)
        thetas = np.repeat(rng.choice([-1.0, 1.0], 600 // jumps + 1), jumps)
        for tick in range(600):
            k = found.K.frozen(thetas[tick])
            assert k.dt == 0.1
            w = rng.standard_normal(2) * (tick < 300)
            y = p["C2"] @ x + p["D21"] @ w
            u = k.C @ xk + k.D @ y
            z = p["C1"] @ x + p["D12"] @ u
            energy += [z @ z, w @ w]
            x = (p["A"] + thetas[tick] * p["Bt"] @ p["Ct"]) @ x + p["B1"] @ w + p["B2"] @ u
            xk = k.A @ xk + k.B @ y
        assert np.sqrt(energy[0] / energy[1]) < found.gam


def test_the_gain_of_a_loop(sq: ModuleType) -> None:
    """IQClab's first demonstration at 0.3: published 2.683535 for any trajectory, 2.00650064 if constant."""
    P = {
        "A": [[-2, -3], [1, 1]], "Bt": [[0.3, 0], [0, 0]], "B1": [[1], [0]], "Ct": [[1, 0], [0, 0]], "C1": [[1, 0]],
        "Dtt": [[0.3, -0.6], [0.3, -0.3]], "Dt1": [[0], [1]], "D1t": [[0, 0.3]], "D11": [[0]],
    }  # fmt: skip
    found = sq.lpvgain(P, [2])
    assert 2.683534 <= found.proved <= 2.683535 * 1.002
    assert found.constant_lower <= 2.0065007 <= found.constant_upper
    assert found.certificate.verify().gamma == found.proved


def test_the_gain_of_a_loop_in_discrete_time(sq: ModuleType) -> None:
    """`x+ = (0.25 + 0.25 theta) x + w` from w to x: 2 at theta = 1, and no trajectory of theta is worse."""
    P = {
        key: [[value]] for key, value in {"A": 0.25, "Bt": 0.25, "B1": 1, "Ct": 1, "C1": 1, "D11": 0}.items()
    }
    P |= {key: [[0]] for key in ("Dtt", "Dt1", "D1t")}
    found = sq.lpvgain(P, [1], dt=0.1)
    assert 2.0 <= found.proved <= 2.0 * 1.003
    assert found.constant_lower <= 2.0 * (1 + TOLERANCE) and found.constant_upper * (1 + TOLERANCE) >= 2.0
    assert "l2 gain" in found.certificate.verify().claim


def test_mu(sq: ModuleType) -> None:
    case = json.loads((CASES / "mu01_slicot_ab13md.json").read_text(encoding="utf-8"))
    M = np.array([[complex(*v) if isinstance(v, list) else v for v in row] for row in case["data"]["M"]])
    found = sq.mu(M, case["data"]["blocks"])
    assert found.upper == pytest.approx(case["expected"]["mu_upper"], rel=1e-6)
    assert found.lower <= found.upper
    assert abs(np.linalg.det(np.eye(len(M)) - M @ found.delta)) < 1e-6
    one = sq.mu(sq.StateSpace(*map(np.atleast_2d, ([-1.0], [1.0], [1.0], [0.0]))), [[-1, 0]])
    assert one.upper == pytest.approx(1.0, rel=1e-3)


def test_a_full_block_is_the_norm(sq: ModuleType) -> None:
    """Mu of one full complex block over all frequencies equals the H-infinity norm."""
    rng = np.random.default_rng(1)
    a = rng.standard_normal((4, 4))
    a -= (np.linalg.eigvals(a).real.max() + 0.2) * np.eye(4)
    parts = [a, rng.standard_normal((4, 2)), rng.standard_normal((3, 4)), rng.standard_normal((3, 2))]
    system = sq.StateSpace(*parts)
    norm, frequency = sq.hinfnorm(system)
    found = sq.mu(system, [[2, 3]])
    assert found.lower <= norm * (1 + 1e-6) and norm <= found.upper * (1 + 1e-6)
    assert found.upper == pytest.approx(norm, rel=1e-3)
    assert np.linalg.norm(system(1j * frequency), 2) == pytest.approx(norm, rel=1e-6)


def test_an_unstable_system_has_no_norm(sq: ModuleType) -> None:
    assert sq.hinfnorm(sq.StateSpace(*map(np.atleast_2d, ([1.0], [1.0], [1.0], [0.0]))))[0] == float("inf")


@pytest.mark.parametrize(
    ("changed", "kind"),
    [
        ({"A": [[0, 1], [-2, "x"]]}, "InputError"),
        ({"A": [[0, 1], [-2, float("nan")]]}, "InputError"),
        ({"nmeas": 0}, "InputError"),
        ({"ncon": 3}, "InputError"),
        ({"nmeas": 1.5}, "InputError"),
        ({"back_off": 0.0}, "InputError"),
        ({"gamma_limit": -1.0}, "InputError"),
        ({"gamma_limit": 0.1}, "InfeasibleError"),
        ({"B2": [[0], [0]], "A": [[1, 0], [0, 1]]}, "InfeasibleError"),
        ({"fastest_mode": 1e-9}, "NumericalError"),
    ],
)
def test_misuse(sq: ModuleType, changed: dict, kind: str, snapshot: SnapshotAssertion) -> None:
    """One sentence, in one of three kinds; wrong input is also a ValueError."""
    own = {"nmeas": 1, "ncon": 1, "back_off": 0.1, "gamma_limit": None, "fastest_mode": None}
    options = {key: changed.get(key, value) for key, value in own.items()}
    with pytest.raises(getattr(sq, kind)) as raised:
        data = {key: value for key, value in changed.items() if key not in own}
        if any(isinstance(v, str) for row in data.get("A", []) for v in row):
            P, _, _ = spring(sq)
            P = (data["A"], P.B, P.C, P.D)
        else:
            P, _, _ = spring(sq, **data)
        sq.hinfsyn(P, options.pop("nmeas"), options.pop("ncon"), **options)
    assert isinstance(raised.value, sq.SquidError)
    assert (kind == "InputError") == isinstance(raised.value, ValueError)
    assert (str(raised.value) if kind == "InputError" else masked(str(raised.value))) == snapshot


def test_a_forged_certificate(sq: ModuleType) -> None:
    found = sq.hinfsyn_proved(*spring(sq))
    held = json.loads(found.certificate.text)
    held["claims"][0]["gain"]["gamma"] *= 0.5
    with pytest.raises(sq.NumericalError):
        sq.Certificate(json.dumps(held)).verify()
    with pytest.raises(sq.InputError):
        sq.Certificate("nonsense").verify()


@pytest.mark.filterwarnings("ignore:connect")
def test_mixed_sensitivity(sq: ModuleType) -> None:
    """The weighted plant is python-control's, and the controller is that of `hinfsyn` for it."""
    import control

    g = control.ss(
        [[-1.0, 2.0], [0.0, -3.0]], [[1.0, 0.0], [0.5, 2.0]], [[1.0, 1.0], [0.0, 1.0]], np.zeros((2, 2))
    )
    w1, w2, w3 = (
        control.ss([[-0.01]], [[1.0]], [[0.4]], [[0.5]]),
        0.3,
        control.ss([[-9.0]], [[3.0]], [[2.0]], [[0.1]]),
    )
    P = sq.augw(g, w1, w2, w3)
    peer = control.augw(g, w1, control.ss([], [], [], [[w2]]), w3)
    for omega in (0.01, 0.7, 20.0):
        assert P(1j * omega) == pytest.approx(peer(1j * omega), rel=1e-12, abs=1e-12)
    K, CL, (gam, rcond) = sq.mixsyn(g, w1, w2, w3)
    assert gam == sq.hinfsyn(P, 2, 2).gam and len(rcond) == 4
    assert sq.hinfnorm(CL)[0] <= gam * (1.0 + TOLERANCE)
    assert K.D.shape == (2, 2)
    with pytest.raises(sq.InputError, match="W1"):
        sq.augw(g, control.ss([], [], [], np.eye(3)))


def test_h2(sq: ModuleType) -> None:
    """The plant 1/(s - 1) with unit weights and noises: X = Y = 1 + sqrt(2) solve 2 x - x^2 + 1 = 0, F = L = -X."""
    P = sq.StateSpace(*map(np.array, ([[1.0]], [[1.0, 0.0, 1.0]], [[1.0], [0.0], [1.0]],
                                      [[0.0, 0, 0], [0, 0, 1], [0, 1, 0]])))  # fmt: skip
    K, CL, gam = sq.h2syn(P, 1, 1)
    root = 1.0 + np.sqrt(2.0)
    assert np.squeeze(K(0.3j)) == pytest.approx(-(root**2) / (0.3j - 1.0 + 2.0 * root), rel=1e-9)
    assert gam == pytest.approx(np.sqrt(root + root**3), rel=1e-9) and len(CL.A) == 2
    P.D[0, 0] = 0.1
    with pytest.raises(sq.NumericalError, match="D11"):
        sq.h2syn(P, 1, 1)


def test_mu_synthesis(sq: ModuleType) -> None:
    """The bound is that of `mu` for the loop, and scalings lower it."""
    P, nmeas, ncon = spring(sq)
    blocks = [[1, 0], [1, 0]]
    _, CL, bound, history = sq.musyn(P, nmeas, ncon, blocks)
    assert bound == min(history) and bound <= sq.hinfsyn(P, nmeas, ncon, back_off=0.01).gam
    assert sq.mu(CL, blocks).upper == pytest.approx(bound, rel=1e-3)
