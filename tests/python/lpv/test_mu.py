"""`squid lpv mu`: published structured singular values, the perturbations that attain them, and wrong files."""

from __future__ import annotations

import itertools
import json
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from conftest import Run, masked, named
from fly.stages import ROOT
from scipy import signal
from scipy.linalg import block_diag
from syrupy.assertion import SnapshotAssertion
from test_lpv import refused

pytestmark = pytest.mark.change

CASES = ROOT / "tests" / "cases"
System = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]


def problem(system: System, blocks: list[list[int]]) -> dict:
    """Return a problem file of a system."""
    return {
        "kind": "mu",
        "data": {"P": {k: m.tolist() for k, m in zip("ABCD", system, strict=True)}, "blocks": blocks},
    }


def mu(run_squid: Run, path: Path, value: dict | str) -> tuple[int, dict, str]:
    """Run `squid lpv mu --json` on a problem; return exit code, report and standard error."""
    path.write_text(value if isinstance(value, str) else json.dumps(value), encoding="utf-8")
    done = run_squid("lpv", "mu", path, "--json")
    return done.returncode, json.loads(done.stdout), done.stderr


def bounds(run_squid: Run, path: Path, value: dict) -> dict:
    """Return the report of a bounded problem, with its perturbation verified with NumPy only."""
    code, report, error = mu(run_squid, path, value)
    assert (code, report["status"], report["reason"], error) == (0, "bounded", None, "")
    assert report["seconds"] > 0.0
    data = value["data"]
    if report["delta"] is None:
        assert report["lower"] == 0.0
        return report
    delta = np.array(report["delta"]) @ np.array([1.0, 1j])
    assert_structure(delta, data["blocks"])
    if "M" in data:
        entries = np.array(data["M"], dtype=float)
        m = entries @ np.array([1.0, 1j]) if entries.ndim == 3 else entries
    else:
        m = response(
            tuple(np.array(data["P"][key], dtype=float) for key in "ABCD"), float(report["lower_frequency"])
        )
    assert report["lower"] == pytest.approx(1.0 / np.linalg.norm(delta, 2), rel=1e-9)
    singular = np.linalg.svd(np.eye(len(m)) - m @ delta, compute_uv=False)
    assert singular[-1] <= 1e-8 * max(1.0, singular[0])
    assert report["lower"] <= report["upper"]
    return report


def response(system: System, omega: float) -> np.ndarray:
    """Return the frequency response at a frequency in rad/s."""
    a, b, c, d = system
    if np.isinf(omega):
        return d
    return c @ np.linalg.solve(1j * omega * np.eye(len(a)) - a, b) + d


def assert_structure(delta: np.ndarray, blocks: list[list[int]]) -> None:
    """Assert that a perturbation has the structure, block by block."""
    row = column = 0
    rest = delta.copy()
    for p, q in blocks:
        scalar = q == 0 or (abs(p), q) == (1, 1)
        rows, columns = (abs(p), abs(p)) if scalar else (p, q)
        part = delta[row : row + rows, column : column + columns]
        rest[row : row + rows, column : column + columns] = 0.0
        if scalar:
            assert np.abs(part - part[0, 0] * np.eye(rows)).max() <= 1e-12 * abs(part[0, 0])
        if p < 0:
            assert part[0, 0].imag == 0.0
        row, column = row + rows, column + columns
    assert (row, column) == delta.shape and not rest.any()


def test_example_of_ab13md(run_squid: Run, tmp_path: Path) -> None:
    """Two real scalars, a full block, two complex scalars: the example of SLICOT's AB13MD, which prints 41.74753408."""
    case = json.loads((CASES / "mu01_slicot_ab13md.json").read_text(encoding="utf-8"))
    report = bounds(run_squid, tmp_path / "p.json", case)
    assert report["upper"] == pytest.approx(41.74753408, rel=1e-6)
    assert report["lower"] > 0.99 * report["upper"]
    assert report["frequency"] is None and report["lower_frequency"] is None


def test_four_complex_scalars_with_a_gap(run_squid: Run, tmp_path: Path) -> None:
    """The bound by scalings is 1 and mu is 0.87236: A. Packard, J. C. Doyle, Automatica 29(1), 1993."""
    case = json.loads((CASES / "mu04_packard_doyle_gap.json").read_text(encoding="utf-8"))
    report = bounds(run_squid, tmp_path / "p.json", case)
    assert report["upper"] == pytest.approx(1.0, rel=1e-5)
    assert 0.864 < report["lower"] < 0.87237


@pytest.mark.parametrize("block", [[-1, 0], [-1, 1], [1, 0], [1, 1]])
def test_spinning_satellite(run_squid: Run, tmp_path: Path, block: list[int]) -> None:
    """S. Skogestad, I. Postlethwaite, Multivariable Feedback Control, 2005, section 3.7.1, in closed form.

    The characteristic polynomial is s^2 + (2 + d1 + d2) s + 1 + d1 + d2 + 101 d1 d2.
    """
    a, c = np.array([[0.0, 10.0], [-10.0, 0.0]]), np.array([[1.0, 10.0], [-10.0, 1.0]])
    system = (a - c, -np.eye(2), c, np.zeros((2, 2)))
    report = bounds(run_squid, tmp_path / "p.json", problem(system, [block, block]))
    expected = 10.04987562112089
    assert expected * (1 - 1e-9) <= report["upper"] <= expected * (1 + 1e-4)
    assert expected * (1 - 1e-6) <= report["lower"] <= expected * (1 + 1e-9)
    assert report["frequency"] == pytest.approx(0.0, abs=1e-6)


def gain(rational: tuple[list[float], list[float]]) -> System:
    """Return a scalar transfer function as a state space system."""
    return signal.tf2ss(*rational)


def distillation() -> System:
    """Return the loop N of a distillation column with input uncertainty and a weight on the error, minimal.

    S. Skogestad, I. Postlethwaite, Multivariable Feedback Control, 2005, section 8.11.3: G = G0/(75 s + 1),
    K = 0.7 (75 s + 1)/s G0^-1, wI = (s + 0.2)/(0.5 s + 1), wP = (s/2 + 0.05)/s. The controller inverts the plant: G K
    = 0.7/s I and S = s/(s + 0.7) I, which takes the integrator of wP away. What is left of N by hand:

        -wI T        -wI K S                       T = 0.7/(s + 0.7) I,  K S = 0.7 (75 s + 1)/(s + 0.7) G0^-1,
        wP S G       wP S                          wP S G = (0.5 s + 0.05)/((s + 0.7) (75 s + 1)) G0.
    """
    g0 = np.array([[87.8, -86.4], [108.2, -109.6]])
    inverse = np.linalg.inv(g0)
    i = np.eye(2)
    slow, fast = np.array([1.0, 0.7]), np.array([0.5, 1.0])
    weighted = np.polymul(slow, fast)
    entries = [
        ([-0.7, -0.14], weighted, np.kron([[1, 0], [0, 0]], i)),
        (-0.7 * np.polymul([1.0, 0.2], [75.0, 1.0]), weighted, np.kron([[0, 1], [0, 0]], inverse)),
        ([0.5, 0.05], np.polymul(slow, [75.0, 1.0]), np.kron([[0, 0], [1, 0]], g0)),
        ([0.5, 0.05], slow, np.kron([[0, 0], [0, 1]], i)),
    ]
    return summed([(gain((np.array(num), den)), matrix) for num, den, matrix in entries])


def summed(parts: list[tuple[System, np.ndarray]]) -> System:
    """Return the sum of scalar systems, each times a matrix, with as many copies as the rank of its matrix."""
    a, b, c, d = [], [], [], 0.0
    for (ai, bi, ci, di), matrix in parts:
        u, s, vt = np.linalg.svd(matrix)
        rank = int(np.sum(s > 1e-12 * s[0]))
        i = np.eye(rank)
        a.append(np.kron(i, ai))
        b.append(np.kron(i, bi) @ vt[:rank])
        c.append((u[:, :rank] * s[:rank]) @ np.kron(i, ci))
        d = d + di[0, 0] * matrix
    return block_diag(*a), np.vstack(b), np.hstack(c), d


def test_distillation_column(run_squid: Run, tmp_path: Path) -> None:
    """Robust performance: two complex scalars and a full block; the book has a peak of 5.77."""
    n = distillation()
    plant = response(n, 0.3)
    g0 = np.array([[87.8, -86.4], [108.2, -109.6]])
    g, k = g0 / (75 * 0.3j + 1), 0.7 * (75 * 0.3j + 1) / 0.3j * np.linalg.inv(g0)
    s = np.linalg.inv(np.eye(2) + g @ k)
    wi, wp = (0.3j + 0.2) / (0.15j + 1), (0.15j + 0.05) / 0.3j
    assert plant == pytest.approx(np.block([[-wi * k @ g @ s, -wi * k @ s], [wp * s @ g, wp * s]]), rel=1e-9)
    report = bounds(run_squid, tmp_path / "p.json", problem(n, [[1, 1], [1, 1], [2, 2]]))
    assert report["upper"] == pytest.approx(5.7818, rel=2e-3)
    assert report["frequency"] == pytest.approx(1.4636, rel=2e-3)
    assert report["lower"] > 0.99 * report["upper"]
    stability = (n[0], n[1][:, :2], n[2][:2], n[3][:2, :2])
    report = bounds(run_squid, tmp_path / "s.json", problem(stability, [[1, 1], [1, 1]]))
    assert report["upper"] == pytest.approx(0.5254, rel=2e-3)
    performance = (n[0], n[1][:, 2:], n[2][2:], n[3][2:, 2:])
    report = bounds(run_squid, tmp_path / "n.json", problem(performance, [[2, 2]]))
    assert report["upper"] == pytest.approx(0.5, rel=2e-3)
    assert report["frequency"] == "infinity"


def test_worst_case_gain_of_the_distillation_column(run_squid: Run, tmp_path: Path) -> None:
    """At size 1/mu the worst-case gain equals mu of robust performance; the perturbation attains the printed gain."""
    n = distillation()
    value = problem(n, [[1, 1], [1, 1]])
    value["data"] |= {"performance": [2, 2], "size": 1 / 5.7818}
    code, report, _ = mu(run_squid, tmp_path / "p.json", value)
    assert code == 0
    assert report["upper"] == pytest.approx(0.5254, rel=2e-3)
    found = report["performance"]
    assert found["upper"] == pytest.approx(5.7818, rel=2e-3)
    assert found["gain_upper"] == pytest.approx(5.7818, rel=1e-2)
    assert 0.98 * found["gain_upper"] < found["gain_lower"] <= found["gain_upper"]
    delta = np.array(found["gain_delta"]) @ np.array([1.0, 1j])
    assert_structure(delta, [[1, 1], [1, 1]])
    assert np.linalg.norm(delta, 2) <= (1 + 1e-9) / 5.7818
    m = response(n, float(found["gain_frequency"]))
    perturbed = m[2:, 2:] + m[2:, :2] @ delta @ np.linalg.solve(np.eye(2) - m[:2, :2] @ delta, m[:2, 2:])
    assert np.linalg.norm(perturbed, 2) == pytest.approx(found["gain_lower"], rel=1e-9)
    value["data"]["size"] = 2.0
    code, report, _ = mu(run_squid, tmp_path / "p.json", value)
    assert (code, report["performance"]["gain_upper"]) == (0, None)


def test_isolated_peak_of_a_real_scalar(run_squid: Run, tmp_path: Path) -> None:
    """M = -(8/3) s/(s + 1)^3 is real only at 1/sqrt(3) rad/s, where it is 1; any grid of frequencies gives 0."""
    system = gain(([-8.0 / 3.0, 0.0], np.poly([-1.0, -1.0, -1.0])))
    report = bounds(run_squid, tmp_path / "p.json", problem(system, [[-1, 0]]))
    assert 1.0 - 1e-9 <= report["upper"] <= 1.0 + 1e-4
    assert report["lower"] == pytest.approx(1.0, rel=1e-6)
    assert report["frequency"] == pytest.approx(3**-0.5, rel=1e-4)
    assert report["lower_frequency"] == pytest.approx(3**-0.5, abs=1e-5)


def case(name: str) -> dict:
    """Return a case of the repository."""
    return json.loads((CASES / f"{name}.json").read_text(encoding="utf-8"))


def of_case(value: dict) -> System:
    """Return the system of a problem."""
    a, b, c, d = (np.array(value["data"]["P"][key], dtype=float) for key in "ABCD")
    return a, b, c, d


def test_two_masses(run_squid: Run, tmp_path: Path) -> None:
    """MATLAB's first example of robstab, whose A has entries of 1e11: 0.34645 to 0.34681 at 575.03 rad/s."""
    value = case("mu05_two_masses")
    report = bounds(run_squid, tmp_path / "p.json", value)
    expected = value["expected"]
    assert report["lower"] == pytest.approx(expected["mu_lower"], rel=expected["rtol"])
    assert expected["mu_lower"] <= report["upper"] <= expected["mu_upper"]
    assert report["lower_frequency"] == pytest.approx(expected["omega"], rel=1e-4)


@pytest.mark.parametrize("speed", [1.0, 1e3, 1e-6])
def test_worst_case_gain_of_two_masses(run_squid: Run, tmp_path: Path, speed: float) -> None:
    """MATLAB's first example of wcgain, in any unit of time: the worst corner has a gain of 1.0475."""
    value = case("mu06_two_masses_gain")
    a, b, c, d = of_case(value)
    written = problem((a * speed, b * speed, c, d), value["data"]["blocks"])
    written["data"] |= {"performance": [1, 1], "size": 1.0}
    code, report, error = mu(run_squid, tmp_path / "p.json", written)
    assert (code, error) == (0, "")
    found, gain = report["performance"], value["expected"]["gain"]
    assert found["gain_lower"] == pytest.approx(gain, rel=1e-4)
    assert found["gain_lower"] <= found["gain_upper"] < gain * (1 + 2e-4)
    # At size 1/upper the gain is below upper, and it grows with the size.
    assert 1.02768 < found["lower"] <= found["upper"] < gain
    delta = np.array(found["gain_delta"])[..., 0]
    assert np.diag(delta) == pytest.approx(value["expected"]["delta"])


def test_worst_case_gain_with_a_complex_scalar(run_squid: Run, tmp_path: Path) -> None:
    """MATLAB's example of wcgain prints 5.1036 to 5.1140."""
    value = case("mu10_integrator_gain")
    code, report, error = mu(run_squid, tmp_path / "p.json", value)
    assert (code, error) == (0, "")
    found, expected = report["performance"], value["expected"]
    assert expected["gain_lower"] <= found["gain_lower"] <= found["gain_upper"] <= expected["gain_upper"]


def test_island(run_squid: Run, tmp_path: Path) -> None:
    """The loop is unstable on a disc inside the box of the parameters, away from every corner: mu is 11/3."""
    value = case("mu14_island")
    report = bounds(run_squid, tmp_path / "p.json", value)
    exact, rtol = value["expected"]["mu_true"], value["expected"]["rtol"]
    assert exact * (1 - rtol) <= report["lower"] <= exact <= report["upper"] <= exact * (1 + rtol)


def test_channels_that_form_no_loop(run_squid: Run, tmp_path: Path) -> None:
    """Direct term of an LFT with 20 channels: connections that form no loop do not count."""
    value = case("mu22_lpv4d_direct_term")
    report = bounds(run_squid, tmp_path / "p.json", value)
    exact, rtol = value["expected"]["mu_true"], value["expected"]["rtol"]
    assert exact * (1 - 1e-9) <= report["upper"] <= exact * (1 + rtol)
    assert report["lower"] == pytest.approx(exact, rel=rtol)


@pytest.mark.parametrize("seed", range(3))
def test_other_coordinates(run_squid: Run, tmp_path: Path, seed: int) -> None:
    """A similarity transform with condition number 1e6 does not change the bounds."""
    random = np.random.default_rng(seed)
    n, blocks = 4, [[-1, 0], [-2, 0], [1, 1]]
    a = random.normal(size=(n, n))
    a = a - (np.linalg.eigvals(a).real.max() + 0.3) * np.eye(n)
    b, c, d = random.normal(size=(n, 4)), random.normal(size=(4, n)), 0.2 * random.normal(size=(4, 4))
    u, v = (np.linalg.qr(random.normal(size=(n, n)))[0] for _ in range(2))
    sizes = np.logspace(0.0, 6.0, n)
    t, inverse = u * sizes @ v, (v.T / sizes) @ u.T
    plain = bounds(run_squid, tmp_path / "p.json", problem((a, b, c, d), blocks))
    # `bounds` is not used: in these coordinates NumPy's response is too inaccurate to verify a perturbation.
    similar = (t @ a @ inverse, t @ b, c @ inverse, d)
    code, other, error = mu(run_squid, tmp_path / "q.json", problem(similar, blocks))
    assert (code, error) == (0, "")
    for key in ("upper", "lower"):
        assert other[key] == pytest.approx(plain[key], rel=1e-3)


@pytest.mark.parametrize("seed", range(12))
def test_no_corner_is_worse(run_squid: Run, tmp_path: Path, seed: int) -> None:
    """Real scalars and a real matrix: the largest real eigenvalue over all corners, by NumPy."""
    random = np.random.default_rng(seed)
    sizes = random.integers(1, 4, size=random.integers(1, 5))
    n = int(sizes.sum())
    m = random.normal(size=(n, n))
    best = 0.0
    for corner in itertools.product([-1.0, 1.0], repeat=len(sizes)):
        values = np.linalg.eigvals(m * np.repeat(corner, sizes))
        best = max([best, *values[values.imag == 0.0].real])
    value = {"data": {"M": m.tolist(), "blocks": [[-int(r), 0] for r in sizes]}}
    assert bounds(run_squid, tmp_path / "p.json", value)["lower"] >= best * (1 - 1e-6)


def test_one_scalar_on_many_channels(run_squid: Run, tmp_path: Path) -> None:
    """A real scalar repeated 20 times: mu is the largest real eigenvalue."""
    m = np.random.default_rng(2).normal(size=(20, 20))
    values = np.linalg.eigvals(m)
    exact = np.abs(values[values.imag == 0.0].real).max()
    report = bounds(run_squid, tmp_path / "p.json", {"data": {"M": m.tolist(), "blocks": [[-20, 0]]}})
    assert exact * (1 - 1e-9) <= report["upper"] < exact * 1.001
    assert report["lower"] == pytest.approx(exact, rel=1e-6)


def test_discrete_time(run_squid: Run, tmp_path: Path) -> None:
    """x+ = (-0.9 + delta) x leaves the unit circle at delta = -0.1, at the frequency pi/dt."""
    value = problem((np.array([[-0.9]]), np.eye(1), np.eye(1), np.zeros((1, 1))), [[-1, 0]])
    value["data"]["dt"] = 0.5
    code, report, error = mu(run_squid, tmp_path / "p.json", value)
    assert (code, error) == (0, "")
    assert report["lower"] == pytest.approx(10.0, rel=1e-9) and 10.0 <= report["upper"] < 10.01
    assert report["delta"][0][0][0] == pytest.approx(-0.1)
    assert report["frequency"] == pytest.approx(np.pi / 0.5)
    assert report["lower_frequency"] == pytest.approx(np.pi / 0.5)
    assert " 6.28319 rad/s" in run_squid("lpv", "mu", tmp_path / "p.json").stdout


NOMINAL = {
    "Ybeta": -0.082,
    "Yp": 0.010827,
    "Yr": 0.060268,
    "Ydeltap": 0.002,
    "Ydeltar": 0.0118,
    "Lbeta": -0.84,
    "Lp": -0.76,
    "Lr": 0.74,
    "Ldeltap": 0.095,
    "Ldeltar": 0.06,
    "Nbeta": 0.092,
    "Np": -0.23,
    "Nr": -0.114,
    "Ndeltar": -0.151,
}
# Row of x' and column of [A B] in which a coefficient enters.
PLACES = [
    (0, 0),
    (0, 1),
    (0, 2),
    (0, 4),
    (0, 5),
    (1, 0),
    (1, 1),
    (1, 2),
    (1, 4),
    (1, 5),
    (2, 0),
    (2, 1),
    (2, 2),
    (2, 5),
]


def aircraft() -> System:
    """Return the loop of a transport aircraft, in which each coefficient is c (1 + 0.1 delta).

    G. Ferreres, A Practical Approach to Robustness Analysis, 1999; numbers as in MathWorks' example "Real Mu Analysis".
    x = [beta p r phi], two actuators, u = -K y.
    """
    alpha, g = np.deg2rad(8.0), 0.146418
    rates = np.zeros((4, 6))
    for (row, column), value in zip(PLACES, NOMINAL.values(), strict=True):
        rates[row, column] = value
    scale = -np.pi / 180.0 / g
    entering = np.zeros((4, 14))
    entering[[row for row, _ in PLACES], range(14)] = 1.0
    outputs = np.vstack([scale * rates[0], np.eye(6)[1:4]])
    feed = np.zeros((4, 14))
    feed[0] = scale * entering[0]
    seen = np.zeros((14, 6))
    for i, ((_, column), value) in enumerate(zip(PLACES, NOMINAL.values(), strict=True)):
        seen[i, column] = 0.1 * value
    rates[0, 1:4] += [np.sin(alpha), -np.cos(alpha), g]
    rates[3, 1:3] = [1.0, 0.14]
    k = np.array([[-629.8858, 11.5254, 3.311, 9.4278], [285.9496, 0.3693, -2.6301, -0.5489]])
    first = gain(([-1.77, 399.0], [1.0, 48.2, 399.0]))
    second = gain(([2.6, -1185.0, 27350.0], [1.0, 77.7, 3331.0, 27350.0]))
    aa, ba, ca = (block_diag(first[j], second[j]) for j in range(3))
    state = block_diag(np.eye(4), ca)  # From x and the actuators' states to [x; u].
    a = np.vstack([rates @ state, np.hstack([np.zeros((5, 4)), aa]) - ba @ k @ outputs @ state])
    return a, np.vstack([entering, -ba @ k @ feed]), seen @ state, np.zeros((14, 14))


def test_fourteen_real_coefficients(run_squid: Run, tmp_path: Path) -> None:
    """A power iteration finds 0 here; a search of all 16384 corners gives a margin of 5.4281175 at 0.62285583 rad/s."""
    report = bounds(run_squid, tmp_path / "p.json", problem(aircraft(), [[-1, 0]] * 14))
    assert report["lower"] == pytest.approx(0.18422593, rel=1e-3)
    assert report["lower_frequency"] == pytest.approx(0.62285583, rel=1e-3)
    # The largest bound by scalings at a single frequency is 0.2283190, at 0.66409 rad/s, by SLICOT's AB13MD.
    assert 0.228319 <= report["upper"] < 0.228319 * (1 + 1e-4)


def test_aircraft_of_the_cases() -> None:
    """The file of the case contains the loop that is closed explicitly here."""
    data = json.loads((CASES / "mu13_transport_aircraft.json").read_text(encoding="utf-8"))["data"]
    assert data["blocks"] == [[-1, 0]] * 14
    for key, matrix in zip("ABCD", aircraft(), strict=True):
        assert np.array(data["P"][key]) == pytest.approx(matrix, rel=1e-12, abs=1e-12), key


def test_words(run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion) -> None:
    """The output says that the bound holds for all frequencies, and states the perturbation and the margin."""
    path = tmp_path / "p.json"
    path.write_text(json.dumps(problem(aircraft(), [[-1, 0]] * 14)), encoding="utf-8")
    done = [run_squid("lpv", "mu", file) for file in (path, CASES / "mu04_packard_doyle_gap.json")]
    assert [one.returncode for one in done] == [0, 0]
    assert [masked(re.sub(r"\d+ intervals", "# intervals", one.stdout)) for one in done] == snapshot


@pytest.mark.parametrize(
    ("m", "blocks", "exact"),
    [
        ([[1, 2], [3, 4]], [[2, 2]], 5.464985704219043),
        ([[1, 2], [3, 4]], [[2, 0]], 5.372281323269014),
        ([[1, 2], [3, 4]], [[-2, 0]], 5.372281323269014),
        ([[3, 4]], [[2, 1]], 5.0),
        ([[[0, 2]]], [[1, 1]], 2.0),
        ([[0, 0], [0, 0]], [[1, 1], [-1, 0]], 0.0),
    ],
)
def test_exact(run_squid: Run, tmp_path: Path, m: list, blocks: list, exact: float) -> None:
    """A full block, square or not, gives the largest singular value; a repeated scalar the spectral radius."""
    report = bounds(run_squid, tmp_path / "p.json", {"data": {"M": m, "blocks": blocks}})
    assert exact * (1 - 1e-9) <= report["upper"] <= exact * (1 + 1e-4)
    assert exact * (1 - 1e-4) <= report["lower"] <= exact * (1 + 1e-9)


def test_real_scalar_that_does_nothing(run_squid: Run, tmp_path: Path) -> None:
    """1 - j delta is never zero for a real delta: no lower bound, and an upper one of about zero."""
    report = bounds(run_squid, tmp_path / "p.json", {"data": {"M": [[[0, 1]]], "blocks": [[-1, 0]]}})
    assert report["delta"] is None and 0.0 <= report["upper"] < 1e-6


KINDS = {"real": "r", "complex": "c", "full": "f", "mixed": "rcf"}
RANDOM_PROBLEMS = 10


def random_blocks(random: np.random.Generator, kinds: str) -> list[list[int]]:
    """Return one to four blocks, with scalars repeated up to three times and non-square full blocks."""
    sign = {"r": -1, "c": 1}
    drawn = [kinds[random.integers(len(kinds))] for _ in range(random.integers(1, 5))]
    sizes = [(int(random.integers(1, 4)), int(random.integers(1, 4))) for _ in drawn]
    return [[p, q] if k == "f" else [sign[k] * p, 0] for k, (p, q) in zip(drawn, sizes, strict=True)]


@pytest.mark.parametrize("kind", KINDS)
def test_random_problems(run_squid: Run, tmp_path: Path, kind: str) -> None:
    """Matrices and systems, some real, of low rank or badly scaled: consistent bounds, perturbations as stated."""
    for seed in range(RANDOM_PROBLEMS):
        random = np.random.default_rng(seed)
        blocks = random_blocks(random, KINDS[kind])
        w = sum(abs(p) for p, _ in blocks)
        z = sum(q or abs(p) for p, q in blocks)
        m = random.normal(size=(z, w)) + 1j * random.normal(size=(z, w)) * (seed % 4 != 3)
        if seed % 5 == 4:
            m = np.outer(m[:, 0], m[0])
        m = m * 10.0 ** random.uniform(-4.0, 4.0, size=(z, 1) if seed % 3 == 2 else 1)
        entries = np.stack([m.real, m.imag], axis=-1).tolist()
        bounds(run_squid, tmp_path / "m.json", {"data": {"M": entries, "blocks": blocks}})
        n = int(random.integers(1, 5))
        a = random.normal(size=(n, n))
        a = a - (np.linalg.eigvals(a).real.max() + 10.0 ** random.uniform(-2.0, 0.5)) * np.eye(n)
        b, c, d = random.normal(size=(n, w)), random.normal(size=(z, n)), random.normal(size=(z, w))
        bounds(run_squid, tmp_path / "p.json", problem((a, b, c, d * (seed % 3 == 0)), blocks))


@pytest.mark.parametrize("blocks", [[[2, 0]], [[1, 1], [-1, 0]]])
def test_what_cannot_come_back(run_squid: Run, tmp_path: Path, blocks: list[list[int]]) -> None:
    """I - M Delta with M = [0 1; 0 0] has determinant 1 for all of these, so mu is zero; that of M = 1e-300 is not."""
    report = bounds(run_squid, tmp_path / "p.json", {"data": {"M": [[0, 1], [0, 0]], "blocks": blocks}})
    assert report["lower"] == 0.0 and report["upper"] < 1e-5
    report = bounds(run_squid, tmp_path / "p.json", {"data": {"M": [[1e-300]], "blocks": [[1, 1]]}})
    assert report["upper"] == pytest.approx(1e-300, rel=1e-4)
    zero = (np.zeros((0, 0)), np.zeros((0, 2)), np.zeros((2, 0)), np.zeros((2, 2)))
    assert bounds(run_squid, tmp_path / "p.json", problem(zero, blocks))["upper"] < 1e-50


@pytest.mark.parametrize("n", [0, 2])
def test_nothing_passes_through_zeros(run_squid: Run, tmp_path: Path, n: int) -> None:
    """Systems with and without states: mu is zero at every frequency, and no small number changes that."""
    zero = (-np.eye(n), np.zeros((n, 4)), np.zeros((4, n)), np.zeros((4, 4)))
    report = bounds(run_squid, tmp_path / "p.json", problem(zero, [[1, 0], [3, 3]]))
    assert report["lower"] == 0.0 and report["upper"] < 1e-50


MATRIX = {"M": [[1, [0, 2]], [3, 4]], "blocks": [[-1, 0], [1, 1]]}
SYSTEM = {"P": {"A": [[-1]], "B": [[1]], "C": [[1]], "D": [[0]]}, "blocks": [[-1, 0]]}


@pytest.mark.parametrize(
    ("data", "spoil", "line", "key"),
    [
        (MATRIX, lambda d: d.pop("M"), None, "M"),
        (MATRIX, lambda d: d.update(P=SYSTEM["P"]), None, "M"),
        (MATRIX, lambda d: d.update(M=[]), None, "M"),
        (MATRIX, lambda d: d.update(M=3), 1, "data.M"),
        (MATRIX, lambda d: d["M"][0].pop(), 1, "data.M"),
        (MATRIX, lambda d: d["M"][0].__setitem__(1, [1, 2, 3]), 1, "data.M[0][1]"),
        (MATRIX, lambda d: d["M"][1].__setitem__(0, "x"), 1, "data.M[1][0]"),
        (MATRIX, lambda d: d["M"][1].__setitem__(0, [0, None]), 1, "data.M[1][0]"),
        (MATRIX, lambda d: d["M"][1].__setitem__(0, 1e200), 1, "data.M[1][0]"),
        (MATRIX, lambda d: d.pop("blocks"), None, "blocks"),
        (MATRIX, lambda d: d.update(blocks=[]), None, "blocks"),
        (MATRIX, lambda d: d.update(blocks=[2]), 1, "data.blocks[0]"),
        (MATRIX, lambda d: d.update(blocks=[[1, 1], [1]]), 1, "data.blocks[1]"),
        (MATRIX, lambda d: d.update(blocks=[[1.5, 0]]), None, "blocks"),
        (MATRIX, lambda d: d.update(blocks=[[1, 1], [-2, 2]]), None, "blocks"),
        (MATRIX, lambda d: d.update(blocks=[[0, 0], [2, 0]]), None, "blocks"),
        (MATRIX, lambda d: d.update(blocks=[[3, 0]]), None, "M"),
        (MATRIX, lambda d: d.update(blocks=[[2, 1]]), None, "M"),
        (SYSTEM, lambda d: d["P"].pop("A"), None, "A"),
        (SYSTEM, lambda d: d["P"].pop("D"), None, "D"),
        (SYSTEM, lambda d: d["P"].update(A=[[-1, 0]]), None, "A"),
        (SYSTEM, lambda d: d["P"].update(B=[[1, 2]]), None, "B"),
        (SYSTEM, lambda d: d["P"].update(C=[[1], [2]]), None, "C"),
        (SYSTEM, lambda d: d.update(blocks=[[-2, 0]]), None, "D"),
        (SYSTEM, lambda d: d.update(performance=[1, 1]), None, "D"),
        (SYSTEM, lambda d: d.update(performance=[1]), 1, "data.performance"),
        (SYSTEM, lambda d: d.update(performance=[1, 0]), None, "performance"),
        (SYSTEM, lambda d: d.update(dt=0), None, "dt"),
        (SYSTEM, lambda d: (d.update(dt=1), d["P"].update(A=[[1.5]])), None, "A"),
        (MATRIX, lambda d: d.update(dt=1), None, "dt"),
        (SYSTEM, lambda d: d.update(sample_time=1), 1, "data.sample_time"),
        (SYSTEM, lambda d: d.update(block=[]), 1, "data.block"),
        (SYSTEM, lambda d: d["P"].update(E=[[1]]), 1, "data.P.E"),
        (SYSTEM, lambda d: d.update(size=0), None, "size"),
        (MATRIX, lambda d: d.update(performance=[1, 1], blocks=[[1, 1]]), None, "performance"),
    ],
)
def test_wrong_file(
    run_squid: Run,
    tmp_path: Path,
    data: dict,
    spoil: Callable[[dict], object],
    line: int | None,
    key: str,
    snapshot: SnapshotAssertion,
) -> None:
    """A problem that cannot be bounded is refused with one sentence that names the file."""
    data = json.loads(json.dumps(data))
    spoil(data)
    code, report, error = mu(run_squid, tmp_path / "p.json", {"kind": "mu", "data": data})
    assert refused(code, report, error) == (line, key)
    assert report["upper"] is None and report["lower"] is None
    assert named(error, TMP=tmp_path) == snapshot


@pytest.mark.parametrize("pole", [0.5, 0.0])
def test_an_unstable_system_is_refused(
    run_squid: Run, tmp_path: Path, pole: float, snapshot: SnapshotAssertion
) -> None:
    system = json.loads(json.dumps(SYSTEM))
    system["P"]["A"] = [[pole]]
    code, report, error = mu(run_squid, tmp_path / "p.json", {"data": system})
    assert (code, report["status"], report["key"], report["upper"]) == (1, "error", "mu", None)
    assert named(error, TMP=tmp_path) == snapshot


@pytest.mark.parametrize(
    ("text", "line", "key"),
    [
        ('{"data": [}', 1, "data[0]"),
        ('{"data": {"M": [[1]], "M": [[2]], "blocks": [[1, 1]]}}', 1, "data"),
        ('{"data": {"M": [[Infinity]], "blocks": [[1, 1]]}}', 1, "data.M[0][0]"),
        ("[]", 1, ""),
        ('{"data": {"M": [[1]], "blocks": [[1, 1]]}, "speed": 1}', 1, "speed"),
        ('{"data": {"M": [[1]], "blocks": [[1, 1]]}, "dt": 1}', None, "dt"),
    ],
)
def test_wrong_text(
    run_squid: Run, tmp_path: Path, text: str, line: int | None, key: str, snapshot: SnapshotAssertion
) -> None:
    """Text that is not a problem file is refused likewise."""
    code, report, error = mu(run_squid, tmp_path / "p.json", text)
    assert refused(code, report, error) == (line, key)
    assert named(error, TMP=tmp_path) == snapshot


def test_command_line(run_squid: Run, tmp_path: Path) -> None:
    """A missing file ends with 1 and one object, a wrong command line with 64; --help describes the input."""
    done = run_squid("lpv", "mu", tmp_path / "p.json", "--json")
    found = json.loads(done.stdout)
    assert (done.returncode, found["key"], found["upper"]) == (1, "not_found", None)
    assert run_squid("lpv", "mu").returncode == 64
    assert run_squid("lpv", "mu", "p.json", "--grid").returncode == 64
    done = run_squid("lpv", "mu", "--help")
    assert done.returncode == 0 and "[-r, 0]" in done.stdout
