"""MATLAB files, through SciPy."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from squid_lpv import systems
from squid_lpv.errors import InputError
from squid_lpv.synthesis import HinfSynthesis, Proved
from squid_lpv.systems import StateSpace


def savemat(path: str | Path, found: HinfSynthesis | Proved) -> None:
    """Write K, CL and gam to a .mat file: after MATLAB's `load`, `ss(K.a, K.b, K.c, K.d, K.Ts)` is the controller."""
    from scipy.io import savemat as write

    synthesis = found.synthesis if isinstance(found, Proved) else found
    parts = {name: _struct(getattr(synthesis, name)) for name in ("K", "CL")}
    write(path, {**parts, "gam": synthesis.gam, "rcond": synthesis.rcond})


def _struct(system: Any) -> dict[str, Any]:
    s = systems.of(system)
    # MATLAB writes an unspecified sample time as -1.
    return {"a": s.A, "b": s.B, "c": s.C, "d": s.D, "Ts": -1.0 if s.dt is True else s.dt}


def loadmat(path: str | Path, name: str = "P") -> tuple[StateSpace, int, int]:
    """Read a plant from a .mat file as `P, nmeas, ncon`, the arguments of `hinfsyn`.

    The file has the matrices A, B, C, D in a struct `name` or at its top level, with nmeas and ncon (or MATLAB's ncont)
    at the top level; or A, B1, B2, C1, C2, D11, D12, D21 (and D22), whose shapes give nmeas and ncon. Ts is the sample
    time. Names may be in upper or lower case.

    Raises:
        InputError: a matrix is missing, or the sizes of the matrices do not match.

    """
    from scipy.io import loadmat as read

    held = read(path, simplify_cells=True)
    parts = held.get(name, held)
    lowered = {str(key).lower(): value for key, value in parts.items() if not key.startswith("__")}
    if "b2" in lowered:
        parts, counts = _joined(path, name, lowered)
    else:
        counts = {
            key: held.get(key, held.get("ncont" if key == "ncon" else key)) for key in ("nmeas", "ncon")
        }
        for key, count in counts.items():
            if count is None:
                raise InputError(f"{path}: '{key}' is missing; it is the number that hinfsyn takes")
        parts = _found(path, name, lowered, ["a", "b", "c", "d"])
    a, b, c, d = (_matrix(path, key, value) for key, value in parts.items())
    n = len(a)
    b, c = _shaped(path, "b", b, n, -1), _shaped(path, "c", c, -1, n)
    d = _shaped(path, "d", d, c.shape[0], b.shape[1])
    time = float(lowered.get("ts", 0.0))
    plant = systems.of(StateSpace(a, b, c, d, True if time == -1.0 else time), name)
    return plant, int(counts["nmeas"]), int(counts["ncon"])


def _found(path: str | Path, name: str, held: dict[str, Any], keys: list[str]) -> dict[str, Any]:
    for key in keys:
        if key not in held:
            raise InputError(f"{path}: '{key}' of '{name}' is missing; it has {', '.join(sorted(held))}")
    return {key: held[key] for key in keys}


def _matrix(path: str | Path, key: str, value: Any) -> np.ndarray:
    return systems.matrix(f"{path}: '{key}'", value)


def _shaped(path: str | Path, key: str, value: np.ndarray, rows: int, columns: int) -> np.ndarray:
    """Return a matrix with its shape restored, which MATLAB's vectors lose."""
    try:
        return value.reshape(rows, columns)
    except ValueError:
        expected = " x ".join("any" if size < 0 else str(size) for size in (rows, columns))
        found = " x ".join(map(str, value.shape))
        raise InputError(f"{path}: '{key}' is {found}; it must be {expected}") from None


def _joined(
    path: str | Path, name: str, held: dict[str, Any]
) -> tuple[dict[str, np.ndarray], dict[str, int]]:
    """Return A, B, C, D of a partitioned plant, and the numbers of measurements and controls."""
    keys = ["a", "b1", "b2", "c1", "c2", "d11", "d12", "d21"]
    m = {key: _matrix(path, key, value) for key, value in _found(path, name, held, keys).items()}
    n = len(m["a"])
    b1, b2 = (_shaped(path, key, m[key], n, -1) for key in ("b1", "b2"))
    c1, c2 = (_shaped(path, key, m[key], -1, n) for key in ("c1", "c2"))
    (w, u), (z, y) = (b1.shape[1], b2.shape[1]), (len(c1), len(c2))
    d22 = _matrix(path, "d22", held.get("d22", np.zeros((y, u))))
    direct = {"d11": (m["d11"], z, w), "d12": (m["d12"], z, u), "d21": (m["d21"], y, w), "d22": (d22, y, u)}
    d11, d12, d21, d22 = (_shaped(path, key, *given) for key, given in direct.items())
    joined = {"a": m["a"], "b": np.hstack([b1, b2]), "c": np.vstack([c1, c2])}
    return {**joined, "d": np.block([[d11, d12], [d21, d22]])}, {"nmeas": y, "ncon": u}
