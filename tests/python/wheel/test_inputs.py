"""Forms of plants: transfer functions, MATLAB files, complex numbers by mistake."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from conftest import masked, named
from fly.stages import ROOT
from syrupy.assertion import SnapshotAssertion

pytestmark = pytest.mark.change

LAG = ([1.0], [1.0, 0.6, 1.0])
"""1/(s^2 + 0.6 s + 1): its norm is 1/(2 zeta sqrt(1 - zeta^2)) with zeta = 0.3."""
PEAK = 1.0 / (0.6 * np.sqrt(1.0 - 0.09))
PARTS = {
    "A": [[0.0, 1.0], [-2.0, -0.5]], "B1": [[0.0, 0.0], [1.0, 0.0]], "B2": [[0.0], [1.0]],
    "C1": [[1.0, 0.0], [0.0, 0.0]], "C2": [[1.0, 0.0]],
    "D11": np.zeros((2, 2)), "D12": [[0.0], [0.3]], "D21": [[0.0, 0.1]],
}  # fmt: skip


def whole() -> dict:
    """Return the plant as four matrices."""
    m = {key: np.array(value) for key, value in PARTS.items()}
    d = np.block([[m["D11"], m["D12"]], [m["D21"], np.zeros((1, 1))]])
    return {"A": m["A"], "B": np.hstack([m["B1"], m["B2"]]), "C": np.vstack([m["C1"], m["C2"]]), "D": d}


def test_transfer_functions(sq: ModuleType) -> None:
    import control
    import scipy.signal

    for system in (control.tf(*LAG), scipy.signal.TransferFunction(*LAG)):
        assert sq.hinfnorm(system)[0] == pytest.approx(PEAK, rel=1e-9)
    assert sq.mu(control.tf(*LAG), [[1, 1]]).upper == pytest.approx(PEAK, rel=1e-3)


def test_what_cannot_be_converted(sq: ModuleType, snapshot: SnapshotAssertion) -> None:
    """Complex matrices are refused, too: NumPy would drop the imaginary part with a warning."""
    import control

    one = ([[-1.0]], [[1.0, 1.0]], [[1.0]], [[0.0, 0.0]])
    calls = {
        "not proper": lambda: sq.mu(control.tf([1.0, 0.0, 0.0], [1.0, 1.0]), [[1, 1]]),
        "rows of different lengths": lambda: sq.mu(([[1.0]], [[1.0, 2.0]]), [[1, 1]]),
        "parts": lambda: sq.hinfnorm(PARTS),
        "complex": lambda: sq.hinfnorm(([[-1.0 + 1.0j]], [[1.0]], [[1.0]], [[0.0]])),
        "complex type": lambda: sq.lpvgain({"A": np.array([[-1.0 + 0.0j]])}, [1]),
        "one output": lambda: sq.hinfsyn(one, 1, 1),
    }
    assert reasons(sq.InputError, calls) == snapshot


def reasons(kind: type[Exception], calls: dict[str, Callable[[], object]]) -> dict[str, str]:
    """Return the message with which each call is refused."""
    found = {}
    for what, call in calls.items():
        with pytest.raises(kind) as raised:
            call()
        found[what] = str(raised.value)
    return found


@pytest.mark.parametrize(
    "held",
    [
        {**whole(), "nmeas": 1, "ncon": 1},
        {**whole(), "nmeas": 1, "ncont": 1},
        {"P": {key.lower(): value for key, value in whole().items()}, "nmeas": 1, "ncont": 1},
        PARTS,
        {"P": {**PARTS, "D22": [[0.0]]}},
    ],
    ids=["four", "ncont", "struct", "parts", "struct of parts"],
)
def test_files_of_matlab(sq: ModuleType, tmp_path: Path, held: dict) -> None:
    from scipy.io import savemat

    savemat(tmp_path / "plant.mat", held)
    P, nmeas, ncon = sq.loadmat(tmp_path / "plant.mat")
    assert (nmeas, ncon) == (1, 1)
    assert all(np.array_equal(getattr(P, key), value) for key, value in whole().items())


@pytest.mark.parametrize(
    "held",
    [
        {key: value for key, value in PARTS.items() if key != "C1"},
        {**PARTS, "D12": [[0.0]]},
        {**whole(), "nmeas": 1},
        {**whole(), "A": np.eye(2) * 1j, "nmeas": 1, "ncon": 1},
    ],
    ids=["C1", "D12", "ncon", "complex"],
)
def test_files_that_do_not_fit(
    sq: ModuleType, tmp_path: Path, held: dict, snapshot: SnapshotAssertion
) -> None:
    from scipy.io import savemat

    savemat(tmp_path / "plant.mat", held)
    with pytest.raises(sq.InputError) as raised:
        sq.loadmat(tmp_path / "plant.mat")
    assert named(str(raised.value), TMP=tmp_path) == snapshot


def test_robust_performance(sq: ModuleType) -> None:
    """For x' = -x + 0.5 delta x + w, z = x, the gain at zero frequency is 1/(1 - 0.5 delta), 2 at delta = 1.

    With a full block from z to w, mu is 0.5 + 1: the inverse of the size at which the loop is singular.
    """
    system = sq.StateSpace(*map(np.array, ([[-1.0]], [[0.5, 1.0]], [[1.0], [1.0]], np.zeros((2, 2)))))
    found = sq.mu(system, [[-1, 0]], performance=(1, 1), size=1.0)
    assert found.upper == pytest.approx(0.5, rel=1e-3)
    assert found.performance.gain_lower == pytest.approx(2.0, rel=1e-3)
    assert found.performance.gain_upper == pytest.approx(2.0, rel=1e-3)
    assert found.performance.gain_delta == pytest.approx(np.array([[1.0]]), rel=1e-6)
    assert found.performance.lower <= 1.5 * (1 + 1e-6) and found.performance.upper == pytest.approx(
        1.5, rel=1e-3
    )
    assert sq.mu(system, [[-1, 0], [1, 1]]).performance is None
    with pytest.raises(sq.InputError, match=r"'size'.*'performance'"):
        sq.mu(system, [[-1, 0], [1, 1]], size=1.0)


def test_mu_in_discrete_time(sq: ModuleType) -> None:
    """x+ = 0.5 x + w has its peak at z = 1: 1/(1 - 0.5)."""
    found = sq.mu(sq.StateSpace(*map(np.atleast_2d, ([0.5], [1.0], [1.0], [0.0])), 0.1), [[1, 1]])
    assert found.upper == pytest.approx(2.0, rel=1e-3)


def test_the_examples_of_the_documentation(
    sq: ModuleType, capsys: pytest.CaptureFixture, snapshot: SnapshotAssertion
) -> None:
    text = (ROOT / "docs" / "python.md").read_text(encoding="utf-8")
    for example in re.findall(r"```python\n(.*?)```", text, re.DOTALL):
        exec(example, {})
    printed = capsys.readouterr().out
    assert printed.count(" 2.000") == 2 and masked(printed) == snapshot
    least, proved = map(float, re.search(r"least gamma (\S+), .* K: (\S+)", printed).groups())
    assert least < proved < 1.1 * least
