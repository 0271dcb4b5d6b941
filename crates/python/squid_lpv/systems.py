"""Linear systems: any object with A, B, C, D is accepted; the result is python-control's StateSpace if installed."""

from __future__ import annotations

import importlib.util
from dataclasses import dataclass
from typing import Any

import numpy as np

from squid_lpv.errors import InputError

Matrix = np.ndarray


@dataclass(frozen=True)
class StateSpace:
    """System `x' = A x + B u`, `y = C x + D u`; in discrete time, with sample time `dt` (s), `x+` in place of `x'`.

    `dt` is 0 in continuous time, and True for an unspecified sample time, as in python-control.
    """

    A: Matrix
    B: Matrix
    C: Matrix
    D: Matrix
    dt: float | bool = 0.0

    def __call__(self, s: complex) -> Matrix:
        """Return `C (s I - A)^-1 B + D`."""
        n = len(self.A)
        return self.C @ np.linalg.solve(s * np.eye(n) - self.A, self.B.astype(complex)) + self.D

    @property
    def sample_time(self) -> float:
        """Sample time; 1 if it is unspecified, since gains do not depend on it."""
        return 1.0 if self.dt is True else float(self.dt)

    def poles(self) -> Matrix:
        """Return the eigenvalues of A."""
        return np.linalg.eigvals(self.A)


def matrix(name: str, value: Any) -> Matrix:
    """Return a matrix of finite numbers.

    Raises:
        InputError: the value is not a matrix of finite numbers.

    """
    try:
        if np.iscomplexobj(value):
            raise TypeError("its entries are complex")
        found = np.atleast_2d(np.asarray(value, dtype=float))
    except (TypeError, ValueError) as error:
        raise InputError(f"{name} is no matrix of real numbers: {error}") from None
    if found.ndim != 2:
        raise InputError(f"{name} has {found.ndim} dimensions; a matrix has 2")
    if not np.isfinite(found).all():
        raise InputError(
            f"{name} has a number that is not finite; a weight that grows without limit is not proper"
        )
    return found


def realised(system: Any, name: str) -> Any:
    """Return a transfer function of SciPy or python-control as a state space, and anything else unchanged.

    Raises:
        InputError: it is improper, or has several inputs or outputs, which python-control converts only with slycot.

    """
    if not (hasattr(system, "num") and hasattr(system, "den")):
        return system
    try:
        if hasattr(system, "to_ss"):
            return system.to_ss()
        import control

        return control.ss(system)
    except Exception as error:
        raise InputError(
            f"{name} is a {type(system).__name__} that cannot be converted ({error}); "
            "give it as a state space, as of control.ss"
        ) from None


def of(system: Any, name: str = "P") -> StateSpace:
    """Return a system from an object with A, B, C, D (and `dt`), a sequence of these four, or a transfer function.

    Raises:
        InputError: it is none of these, or the sizes of the matrices do not match.

    """
    system = realised(system, name)
    if all(hasattr(system, part) for part in "ABCD"):
        parts, dt = [getattr(system, part) for part in "ABCD"], getattr(system, "dt", None)
    elif isinstance(system, (tuple, list)) and len(system) in (4, 5):
        parts, dt = list(system[:4]), system[4] if len(system) == 5 else None
    else:
        raise InputError(
            f"{name} is {type(system).__name__}; it must have A, B, C, D, or be a sequence of them, "
            "or a transfer function"
        )
    a, b, c, d = (matrix(f"{name}.{part}", value) for part, value in zip("ABCD", parts, strict=True))
    n = 0 if a.size == 0 else len(a)
    if n == 0:
        a, b, c = np.zeros((0, 0)), np.zeros((0, d.shape[1])), np.zeros((d.shape[0], 0))
    expected = {"A": (n, n), "B": (n, d.shape[1]), "C": (d.shape[0], n)}
    for part, found in {"A": a, "B": b, "C": c}.items():
        if found.shape != expected[part]:
            rows, columns = expected[part]
            raise InputError(
                f"{name}.{part} is {found.shape[0]} x {found.shape[1]}; it must be {rows} x {columns}, "
                f"since D is {d.shape[0]} x {d.shape[1]}"
            )
    if dt is not None and dt is not True and not (np.isreal(dt) and np.isfinite(dt) and dt >= 0.0):
        raise InputError(
            f"{name}.dt is {dt}; it must be 0 or None in continuous time, or a sample time above 0"
        )
    return StateSpace(a, b, c, d, dt if dt is True else float(dt or 0.0))


def given_back(system: StateSpace) -> Any:
    """Return a system as python-control's StateSpace if that is installed, otherwise unchanged."""
    if importlib.util.find_spec("control") is None:
        return system
    import control

    return control.ss(system.A, system.B, system.C, system.D, system.dt, remove_useless_states=False)


def lower_lft(plant: StateSpace, controller: StateSpace) -> StateSpace:
    """Return the loop of `plant` with `u = K y`, in which u and y are the last inputs and outputs of the plant.

    Raises:
        InputError: the loop is not well posed.

    """
    ncon, nmeas = controller.D.shape
    nw, nz = plant.B.shape[1] - ncon, plant.C.shape[0] - nmeas
    b1, b2 = plant.B[:, :nw], plant.B[:, nw:]
    c1, c2 = plant.C[:nz], plant.C[nz:]
    d11, d12, d21, d22 = plant.D[:nz, :nw], plant.D[:nz, nw:], plant.D[nz:, :nw], plant.D[nz:, nw:]
    k = controller
    # u = (I - Dk D22)^-1 (Ck xk + Dk (C2 x + D21 w)), and y = C2 x + D21 w + D22 u.
    try:
        loop = np.linalg.inv(np.eye(ncon) - k.D @ d22)
    except np.linalg.LinAlgError:
        raise InputError(
            "the direct paths of plant and controller make a loop that is not well posed"
        ) from None
    ux, uk, uw = loop @ k.D @ c2, loop @ k.C, loop @ k.D @ d21
    yx, yk, yw = c2 + d22 @ ux, d22 @ uk, d21 + d22 @ uw
    a = np.block([[plant.A + b2 @ ux, b2 @ uk], [k.B @ yx, k.A + k.B @ yk]])
    b = np.vstack([b1 + b2 @ uw, k.B @ yw])
    c = np.hstack([c1 + d12 @ ux, d12 @ uk])
    return StateSpace(a, b, c, d11 + d12 @ uw, plant.dt)
