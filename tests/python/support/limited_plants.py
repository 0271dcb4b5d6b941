"""Plants whose commands have limits, as problems of `squid lpv synth`."""

from __future__ import annotations

import copy

import numpy as np

# A mass on a spring whose stiffness is a parameter, docs/plants.md.
SPRING = {
    "P": {
        "A": [[0, 1], [-2, -0.5]], "Bt": [[0], [-1]], "B1": [[0, 0], [1, 0]], "B2": [[0], [1]], "Ct": [[1, 0]],
        "Dtt": [[0]], "Dt1": [[0, 0]], "Dt2": [[0]], "C1": [[1, 0], [0, 0]], "D1t": [[0], [0]],
        "D11": [[0, 0], [0, 0]], "D12": [[0], [0.3]], "C2": [[1, 0]], "D2t": [[0]], "D21": [[0, 0.1]],
    },
    "blocks": [1], "limits": [1.0],
}  # fmt: skip
# The same on a spring that pushes away.
UNSTABLE = copy.deepcopy(SPRING)
UNSTABLE["P"]["A"] = [[0, 1], [2, -0.5]]
# Two such masses, joined by a third spring, the first pushed: one parameter is in its spring and its damper, another in
# the spring of the second.
TWO_SPRINGS = {
    "P": {
        "A": [[0, 1, 0, 0], [-3, -0.5, 1, 0], [0, 0, 0, 1], [1, 0, -2.5, -0.4]],
        "Bt": [[0, 0, 0], [-1, -0.3, 0], [0, 0, 0], [0, 0, -0.7]], "B1": [[0, 0], [1, 0], [0, 0], [0.3, 0]],
        "B2": [[0], [1], [0], [0]], "Ct": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]],
        "Dtt": [[0, 0, 0], [0, 0, 0], [0, 0, 0]], "Dt1": [[0, 0], [0, 0], [0, 0]], "Dt2": [[0], [0], [0]],
        "C1": [[0, 0, 1, 0], [0, 0, 0, 0]], "D1t": [[0, 0, 0], [0, 0, 0]], "D11": [[0, 0], [0, 0]],
        "D12": [[0], [0.3]], "C2": [[0, 0, 1, 0]], "D2t": [[0, 0, 0]], "D21": [[0, 0.1]],
    },
    "blocks": [2, 1], "limits": [1.0],
}  # fmt: skip
# G = 10/(100 s + 1) [4 -5; -3 4] of demonstration 10 of IQClab, limits of 1, with all but integrated errors.
TANKS = {
    "A": [[-0.01, 0, 0, 0], [0, -0.01, 0, 0], [-1, 0, -0.001, 0], [0, -1, 0, -0.001]],
    "B1": [[0, 0, 0, 0], [0, 0, 0, 0], [1, 0, 0, 0], [0, 1, 0, 0]],
    "B2": [[0.4, -0.5], [-0.3, 0.4], [0, 0], [0, 0]],
    "C1": [[0, 0, 0.1, 0], [0, 0, 0, 0.1], [0, 0, 0, 0], [0, 0, 0, 0]],
    "D11": [[0, 0, 0, 0]] * 4,
    "D12": [[0, 0], [0, 0], [0.3, 0], [0, 0.3]],
    "C2": [[-1, 0, 0, 0], [0, -1, 0, 0]],
    "D21": [[1, 0, 0.01, 0], [0, 1, 0, 0.01]],
    "limits": [1.0, 1.0],
}


def f8() -> dict:
    """Return the F8 with weights and limits: F. Wu, M. Soto, Int. J. Robust Nonlinear Control 14(15), 2004."""
    a = [[-0.8, -0.0006, -12, 0], [0, -0.014, -16.64, -32.2], [1, -0.0001, -1.5, 0], [1, 0, 0, 0]]
    b = [[-19, -3], [-0.66, -0.5], [-0.16, -0.5], [0, 0]]
    c = np.array([[0, 0, 0, 1], [0, 0, -1, 1]])
    # The states are the plant's, those of y_r = 4/(s + 4) r, of (0.5 s + 2.5)/(s + 0.05) and of (s + 5)/(s + 200).
    one, part = np.eye(2), {key: np.zeros(shape) for key, shape in SIZES.items()}
    part["A"][:4, :4], part["A"][4:6, 4:6], part["A"][6:8, :4] = a, -4 * one, c
    part["A"][6:8, 4:6], part["A"][6:8, 6:8], part["A"][8:, 8:] = -one, -0.05 * one, -200 * one
    part["B1"][4:6], part["B2"][:4], part["B2"][8:] = 4 * one, b, one
    part["C1"][:2, :4], part["C1"][:2, 4:6], part["C1"][:2, 6:8] = 0.5 * c, -0.5 * one, 2.475 * one
    part["C1"][2:, 8:], part["C2"][:, :4], part["D12"][2:], part["D21"][:] = -195 * one, -c, one, one
    return {key: value.tolist() for key, value in part.items()} | {"limits": [15.0, 15.0]}


SIZES = {"A": (10, 10), "B1": (10, 2), "B2": (10, 2), "C1": (4, 10), "C2": (2, 10), "D11": (4, 2), "D12": (4, 2),
         "D21": (2, 2)}  # fmt: skip
