"""Evaluate the derivatives of an FMU's states, and their Jacobian, with CasADi, and integrate them with its CVODES.

python derivatives_casadi.py PLAN     reads a plan in JSON and writes the results to the file named in it
"""

from __future__ import annotations

import json
import sys
import zipfile
from pathlib import Path

import casadi


def results(plan: dict, folder: Path) -> dict:
    """Return derivatives and Jacobians at each point of a plan, and the states at the end of the flight."""
    with zipfile.ZipFile(plan["fmu"]) as archive:
        archive.extractall(folder)
    model = casadi.DaeBuilder("model", str(folder))
    states, inputs = plan["states"], plan["inputs"]
    assert sorted(model.x()) == sorted(states)
    assert sorted(model.u()) == sorted(inputs)
    rates = model.create("rates", ["x", "u"], ["ode"])
    jacobian = rates.factory("jacobian", ["x", "u"], ["jac:ode:x"])
    own = [states.index(name) for name in model.x()]
    back = [model.x().index(name) for name in states]
    given = [inputs.index(name) for name in model.u()]
    ordered = casadi.DM([plan["held"][index] for index in given])

    def at(point: list[float]) -> casadi.DM:
        return casadi.DM([point[index] for index in own])

    points = [at(point) for point in plan["points"]]
    x, u = casadi.MX.sym("x", len(states)), casadi.MX.sym("u", len(inputs))
    flight = casadi.integrator(
        "flight",
        "cvodes",
        {"x": x, "p": u, "ode": rates(x=x, u=u)["ode"]},
        0.0,
        plan["duration"],
        {"abstol": plan["tolerance"], "reltol": plan["tolerance"]},
    )
    end = flight(x0=points[0], p=ordered)["xf"]
    return {
        "rates": [rates(x=point, u=ordered)["ode"].full().ravel()[back].tolist() for point in points],
        "jacobians": [
            jacobian(x=point, u=ordered)["jac_ode_x"].full()[back][:, back].tolist() for point in points
        ],
        "end": end.full().ravel()[back].tolist(),
    }


if __name__ == "__main__":
    path = Path(sys.argv[1])
    plan = json.loads(path.read_text(encoding="utf-8"))
    folder = path.with_name("unpacked")
    Path(plan["out"]).write_text(json.dumps(results(plan, folder)), encoding="utf-8")
