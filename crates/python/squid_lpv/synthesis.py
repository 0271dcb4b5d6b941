"""Synthesis of controllers with a proved gain."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, TypedDict

import numpy as np

from squid_lpv import _core, systems
from squid_lpv.certificates import Certificate
from squid_lpv.errors import InfeasibleError, InputError, NumericalError
from squid_lpv.systems import Matrix, StateSpace

Progress = Callable[[str, str, str], Any]
"""Function called with the kind of an event (`began`, `done`, `warning`), the stage, and a text."""

PLANT = (
    "A", "Bt", "B1", "B2", "Ct", "C1", "C2",
    "Dtt", "Dt1", "Dt2", "D1t", "D11", "D12", "D2t", "D21", "D22",
)  # fmt: skip
"""Matrices of a plant with parameters, as `squid lpv synth` reads them."""


class HinfSynthesis(NamedTuple):
    """Result of `hinfsyn`; it unpacks as `K, CL, gam, rcond`."""

    K: Any
    CL: Any
    gam: float
    rcond: list[float]

    def __repr__(self) -> str:
        """Return the gain and the sizes."""
        return f"HinfSynthesis(gam={self.gam:.6g}, states={len(self.K.A)})"


class Finding(TypedDict, total=False):
    """Finding on a synthesis: its kind, the key with value and limit as far as known, and a sentence."""

    kind: str
    key: str
    value: float
    unit: str
    limit: float
    why: str


class Proved(NamedTuple):
    """`HinfSynthesis` with the lowest gamma found, findings, and the proof.

    `is_least`: True if `gamma` is shown, in floating point, to be the least within 0.1 %; otherwise a better controller
    may exist.
    """

    synthesis: HinfSynthesis
    gamma: float
    is_least: bool
    findings: list[Finding]
    certificate: Certificate


def hinfsyn(P: Any, nmeas: int, ncon: int, **options: Any) -> HinfSynthesis:
    """Return an H-infinity controller with a proved gain: `K, CL, gam, rcond`, as python-control's `hinfsyn`.

    Args:
        P: the plant, anything with A, B, C, D; its last `ncon` inputs are u, its last `nmeas` outputs y.
        nmeas: the number of measurements y.
        ncon: the number of controls u.
        options: those of `hinfsyn_proved`.

    Returns:
        K, the controller `u = K y`; CL, the loop from w to z; `gam`: the gain of the loop of P and K is below it,
        proved in exact arithmetic; `rcond`, the conditions of D12 and D21 (least singular value over the largest), and
        twice NaN: those of the Riccati equations, which have 32 digits here, are not computed.

    Raises:
        InfeasibleError: there is no controller.
        NumericalError: the computation was inconclusive.
        InputError: the problem is invalid.

    """
    return hinfsyn_proved(P, nmeas, ncon, **options).synthesis


def hinfsyn_proved(
    P: Any,
    nmeas: int,
    ncon: int,
    *,
    back_off: float = 0.1,
    gamma_limit: float | None = None,
    fastest_mode: float | None = None,
    reduce: bool = False,
    progress: Progress | None = None,
) -> Proved:
    """Return the result of `hinfsyn`, with the lowest gamma found, findings and the certificate.

    A discrete-time plant is converted to continuous time by the bilinear transform, which preserves gains, and its
    controller is converted back. The proof is for the discrete-time loop.

    Args:
        P: as in `hinfsyn`.
        nmeas: as in `hinfsyn`.
        ncon: as in `hinfsyn`.
        back_off: the relative distance of the controller's gamma from the lowest gamma found; from 0.001 to 1.
        gamma_limit: the largest gamma; the problem is infeasible if it is shown that no gamma below this exists.
        fastest_mode: the limit on the modes of the controller, rad/s; in discrete time, on those of its bilinear
            transform to continuous time.
        reduce: remove controller states and channels while the bound stays within 2 %.
        progress: a function called with progress reports.

    """
    plant = systems.of(P)
    _check_sizes(plant, nmeas, ncon)
    data = partition(plant, nmeas, ncon)
    if plant.dt:
        data["dt"] = plant.sample_time
    report, rows, certificate = solve(data, back_off, gamma_limit, fastest_mode, reduce, progress)
    matrices = lpv_controller(rows).matrices
    k = StateSpace(*(matrices[key] for key in ("A", "By", "Cu", "Duy")), plant.dt)
    loop = systems.lower_lft(plant, k)
    d12, d21 = (np.array(data[key]) for key in ("D12", "D21"))
    rcond = [_condition(d12), _condition(d21), float("nan"), float("nan")]
    found = HinfSynthesis(systems.given_back(k), systems.given_back(loop), report["certified_gamma"], rcond)
    return Proved(found, report["gamma"], report["least"], report["findings"], certificate)


def _check_sizes(plant: StateSpace, nmeas: int, ncon: int) -> None:
    """Raise InputError unless P has errors and disturbances in addition to its measurements and controls."""
    outputs, inputs = plant.D.shape
    for name, count, most, of, needs in (
        ("nmeas", nmeas, outputs, "outputs", "errors z and measurements y"),
        ("ncon", ncon, inputs, "inputs", "disturbances w and controls u"),
    ):
        if most < 2:
            raise InputError(f"P has {most} {of}; it needs two or more, {needs}")
        if not (isinstance(count, int | np.integer) and 0 < count < most):
            raise InputError(
                f"{name} is {count}; it must be a whole number from 1 to {most - 1}, since P has {most} {of}"
            )


def augw(g: Any, w1: Any = None, w2: Any = None, w3: Any = None) -> Any:
    """Return the weighted plant of a mixed-sensitivity design, as python-control's `augw`.

    Args:
        g: the plant from u to y, anything with A, B, C, D.
        w1: the weight of the error `e = w - y`; a weight with one input and output applies to all signals.
        w2: the weight of the control u.
        w3: the weight of the output y. At least one weight is required.

    Returns:
        P from `[w; u]` to `[w1 e; w2 u; w3 y; e]`, with e as the measurement.

    """
    plant = systems.of(g, "g")
    if w1 is None and w2 is None and w3 is None:
        raise InputError("w1, w2 and w3 are all None; at least one signal needs a weight")
    given = [None if w is None else _weight(w, f"w{i}", plant.dt) for i, w in enumerate((w1, w2, w3), 1)]
    if any(weight is not None and weight.dt != plant.dt for weight in given):
        raise InputError("g and its weights have different sample times")
    parts = _core.augw(_rows(plant), *(None if weight is None else _rows(weight) for weight in given))
    a, b, c, d = (np.array(part, dtype=float) for part in parts)
    n = len(a)
    return systems.given_back(
        StateSpace(a.reshape(n, n), b.reshape(n, d.shape[1]), c.reshape(len(d), n), d, plant.dt)
    )


def mixsyn(g: Any, w1: Any = None, w2: Any = None, w3: Any = None, **options: Any) -> MixSynthesis:
    """Return the controller for the least gain of `[w1 S; w2 K S; w3 T]`: `K, CL, info`, as python-control's `mixsyn`.

    Args:
        g: as in `augw`.
        w1: as in `augw`.
        w2: as in `augw`.
        w3: as in `augw`.
        options: those of `hinfsyn_proved`.

    Returns:
        K, the controller `u = K e`; CL, the loop from w to z; info, the proved gain and `rcond` of `hinfsyn`.

    """
    plant = systems.of(g, "g")
    outputs, inputs = plant.D.shape
    found = hinfsyn(augw(g, w1, w2, w3), outputs, inputs, **options)
    return MixSynthesis(found.K, found.CL, (found.gam, found.rcond))


class MixSynthesis(NamedTuple):
    """Result of `mixsyn`; it unpacks as `K, CL, info`."""

    K: Any
    CL: Any
    info: tuple[float, list[float]]


class H2Synthesis(NamedTuple):
    """Result of `h2syn`; it unpacks as `K, CL, gam`, as in MATLAB."""

    K: Any
    CL: Any
    gam: float


def h2syn(P: Any, nmeas: int, ncon: int) -> H2Synthesis:
    """Return the H2-optimal controller of a plant in continuous time: `K, CL, gam`.

    Args:
        P: as in `hinfsyn`; D11 is zero, D12 has full column rank, D21 full row rank.
        nmeas: as in `hinfsyn`.
        ncon: as in `hinfsyn`.

    Returns:
        K, the controller `u = K y`; CL, the loop from w to z; gam, its H2 norm, computed, not proved.

    Raises:
        InfeasibleError: no controller stabilises the plant.
        NumericalError: D11, D12, D21 or a zero on the imaginary axis prevents a solution; the message names it.
        InputError: the problem is invalid.

    """
    plant = systems.of(P)
    _check_sizes(plant, nmeas, ncon)
    data = partition(plant, nmeas, ncon)
    if plant.dt:
        data["dt"] = plant.sample_time
    *parts, norm = _core.h2syn(json.dumps({"data": data}))
    k = _controller(parts, ncon, nmeas, plant.dt)
    return H2Synthesis(systems.given_back(k), systems.given_back(systems.lower_lft(plant, k)), norm)


class MuSynthesis(NamedTuple):
    """Result of `musyn`; it unpacks as `K, CL, mu, history`."""

    K: Any
    CL: Any
    mu: float
    history: list[float]


def musyn(
    P: Any,
    nmeas: int,
    ncon: int,
    blocks: Sequence[Sequence[int]],
    *,
    iterations: int = 6,
    order: int = 4,
    progress: Progress | None = None,
) -> MuSynthesis:
    """Return a controller with a small structured singular value, by D-K iteration; the optimum is a local one.

    Args:
        P: as in `hinfsyn`; its first inputs w and outputs z are joined by the perturbation.
        nmeas: as in `hinfsyn`.
        ncon: as in `hinfsyn`.
        blocks: rows in MATLAB's notation, see `mu`; a requirement on the gain from some w to some z is a full block.
        iterations: the largest number of controllers.
        order: the largest order of each scaling; the order of the controller grows with it.
        progress: a function called with progress reports.

    Returns:
        K, the controller `u = K y`; CL, the loop from w to z; mu, the upper bound of its structured singular value at
        every frequency, in floating point; history, that bound for the controller of each iteration.

    Raises:
        InfeasibleError: no controller stabilises the plant.
        NumericalError: the computation was inconclusive.
        InputError: the problem is invalid.

    """
    plant = systems.of(P)
    _check_sizes(plant, nmeas, ncon)
    if iterations < 1 or not 0 <= order <= 10:
        raise InputError(
            f"iterations is {iterations} and order {order}; they must be at least 1, and from 0 to 10"
        )
    data = partition(plant, nmeas, ncon)
    if plant.dt:
        data["dt"] = plant.sample_time
    rows = [(int(p), int(q)) for p, q in np.atleast_2d(np.asarray(blocks)).tolist()]
    *parts, bound, history = _core.musyn(json.dumps({"data": data}), rows, iterations, order, progress)
    k = _controller(parts, ncon, nmeas, plant.dt)
    return MuSynthesis(systems.given_back(k), systems.given_back(systems.lower_lft(plant, k)), bound, history)


def _weight(weight: Any, name: str, dt: float | bool) -> StateSpace:
    """Return a weight (a number, a matrix or a system) as a system."""
    if isinstance(weight, int | float | np.ndarray):
        d = systems.matrix(name, weight)
        return StateSpace(np.zeros((0, 0)), np.zeros((0, d.shape[1])), np.zeros((len(d), 0)), d, dt)
    return systems.of(weight, name)


def _rows(system: StateSpace) -> tuple[Any, Any, Any, Any, int]:
    return *(getattr(system, part).tolist() for part in "ABCD"), system.D.shape[1]


def _controller(parts: Sequence[Any], outputs: int, inputs: int, dt: float | bool) -> StateSpace:
    """Return a controller from lists of rows."""
    n = len(parts[0])
    shapes = ((n, n), (n, inputs), (outputs, n), (outputs, inputs))
    return StateSpace(
        *(np.array(p, dtype=float).reshape(shape) for p, shape in zip(parts, shapes, strict=True)), dt
    )


def partition(plant: StateSpace, nmeas: int, ncon: int) -> dict[str, Any]:
    """Return A, B1, B2, C1, ... of a plant, as lists."""
    nz, nw = plant.D.shape[0] - nmeas, plant.D.shape[1] - ncon
    w, u, z, y = slice(nw), slice(nw, None), slice(nz), slice(nz, None)
    parts = {
        "A": plant.A, "B1": plant.B[:, w], "B2": plant.B[:, u], "C1": plant.C[z], "C2": plant.C[y],
        "D11": plant.D[z, w], "D12": plant.D[z, u], "D21": plant.D[y, w], "D22": plant.D[y, u],
    }  # fmt: skip
    return {key: part.tolist() for key, part in parts.items()}


def solve(
    data: Mapping[str, Any],
    back_off: float,
    gamma_limit: float | None,
    fastest_mode: float | None,
    reduce: bool,
    progress: Progress | None,
) -> tuple[dict[str, Any], dict[str, Any], Certificate]:
    """Return report, controller and certificate of a problem as `squid lpv synth` reads it.

    Raises:
        InfeasibleError: there is no controller.
        NumericalError: the computation was inconclusive.
        InputError: the problem is invalid, or an option is outside the range that the command line allows.

    """
    if not 1e-3 <= back_off <= 1.0:
        raise InputError(f"back_off is {back_off}; it must be from 0.001 to 1")
    for name, value in (("gamma_limit", gamma_limit), ("fastest_mode", fastest_mode)):
        if value is not None and not (np.isfinite(value) and value > 0.0):
            raise InputError(f"{name} is {value}; it must be above 0")
    problem = json.dumps({"data": data})
    text, controller, certificate = _core.synth(
        problem, back_off, gamma_limit, fastest_mode, reduce, progress
    )
    report = json.loads(text)
    if report["status"] == "infeasible":
        raise InfeasibleError(report["reason"])
    if controller is None or certificate is None:
        why = [found["why"] for found in report["findings"]]
        raise NumericalError("; ".join([report["reason"] or "no controller was found", *why]))
    return report, json.loads(controller), Certificate(certificate)


def _condition(m: Matrix) -> float:
    values = np.linalg.svd(m, compute_uv=False)
    return float(values[-1] / values[0]) if values.size and values[0] > 0.0 else 0.0


@dataclass(frozen=True)
class LpvController:
    """`xk' = A xk + By y + Bt wk`, `u = Cu xk + Duy y + Dut wk`, `zk = Ct xk + Dty y + Dtt wk`, `wk = Theta zk`."""

    blocks: list[int]
    matrices: dict[str, Matrix]
    dt: float = 0.0
    """Sample time, s; 0 in continuous time. `xk+` replaces `xk'` in discrete time."""

    def frozen(self, *theta: float) -> Any:
        """Return the controller at constant parameters, each within [-1, 1]."""
        if len(theta) != len(self.blocks):
            raise InputError(f"{len(theta)} parameters are given; the controller has {len(self.blocks)}")
        if not all(-1.0 <= value <= 1.0 for value in theta):
            raise InputError(f"the parameters are {theta}; each must be from -1 to 1")
        m = self.matrices
        diagonal = np.repeat(np.asarray(theta, dtype=float), self.blocks)
        inner = np.linalg.inv(np.eye(len(diagonal)) - diagonal[:, None] * m["Dtt"]) * diagonal[None, :]
        return systems.given_back(
            StateSpace(
                m["A"] + m["Bt"] @ inner @ m["Ct"],
                m["By"] + m["Bt"] @ inner @ m["Dty"],
                m["Cu"] + m["Dut"] @ inner @ m["Ct"],
                m["Duy"] + m["Dut"] @ inner @ m["Dty"],
                self.dt,
            )
        )


@dataclass(frozen=True)
class LpvSynthesis:
    """Result of `lpvsyn`: the controller, its proved gain, the lowest gamma found, findings, and the proof.

    `gam` is None if a gain is proved only with the rate bound: `gam_at_rate`. `is_least`: True if `gamma` is shown, in
    floating point, to be the least of the synthesis inequalities within 0.1 %.
    """

    K: LpvController
    gam: float | None
    gamma: float
    is_least: bool
    gam_at_rate: float | None
    findings: list[Finding]
    certificate: Certificate


def lpvsyn(
    P: Mapping[str, Any],
    blocks: list[int],
    *,
    rate: float | None = None,
    dt: float | None = None,
    back_off: float = 0.1,
    gamma_limit: float | None = None,
    fastest_mode: float | None = None,
    reduce: bool = False,
    progress: Progress | None = None,
) -> LpvSynthesis:
    """Return a controller scheduled by measured parameters, with a gain that is proved for all their trajectories.

    Args:
        P: the matrices A, Bt, B1, B2, Ct, ... of the plant by name (see `PLANT`): `wt = blkdiag(theta_i I_ri) zt`.
        blocks: the repetitions r_1, r_2, ... of the parameters, each within [-1, 1].
        rate: a bound on |theta'| of the only parameter.
        dt: the sample time, s, of a discrete-time plant; its controller and the proof are also in discrete time.
        back_off: as in `hinfsyn_proved`.
        gamma_limit: as in `hinfsyn_proved`.
        fastest_mode: as in `hinfsyn_proved`.
        reduce: as in `hinfsyn_proved`.
        progress: a function called with progress reports.

    Raises:
        InfeasibleError: no controller of the required kind exists, as shown in floating point; the message names the
            kind.
        NumericalError: the computation was inconclusive.
        InputError: the problem is invalid.

    """
    data: dict[str, Any] = {"P": as_lists(P), "blocks": np.asarray(blocks).tolist()}
    data |= without_none(rate=rate, dt=dt)
    report, rows, certificate = solve(data, back_off, gamma_limit, fastest_mode, reduce, progress)
    return LpvSynthesis(
        lpv_controller(rows, dt or 0.0),
        report["certified_gamma"],
        report["gamma"],
        report["least"],
        report.get("certified_gamma_at_rate"),
        report["findings"],
        certificate,
    )


def without_none(**options: float | None) -> dict[str, float]:
    """Return the options that are not None."""
    return {key: value for key, value in options.items() if value is not None}


def lpv_controller(rows: Mapping[str, Any], dt: float = 0.0) -> LpvController:
    """Return a controller from the JSON of `controller.json`."""
    n, r = len(rows["A"]), sum(rows["blocks"])
    outputs = len(rows["Duy"])
    inputs = len(rows["Duy"][0]) if outputs else 0
    size = {"A": (n, n), "By": (n, inputs), "Bt": (n, r), "Cu": (outputs, n), "Duy": (outputs, inputs)}
    size |= {"Dut": (outputs, r), "Ct": (r, n), "Dty": (r, inputs), "Dtt": (r, r)}
    return LpvController(
        list(rows["blocks"]),
        {key: np.array(rows[key], dtype=float).reshape(shape) for key, shape in size.items()},
        dt,
    )


def as_lists(parts: Mapping[str, Any]) -> dict[str, list[list[float]]]:
    """Return matrices by name as lists of rows."""
    unknown = sorted(set(parts) - set(PLANT))
    if unknown:
        raise InputError(f"P has '{unknown[0]}'; its matrices are {', '.join(PLANT)}")
    return {key: systems.matrix(f"P['{key}']", value).tolist() for key, value in parts.items()}
