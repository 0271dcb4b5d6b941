"""The ball around the fit contains the vehicle, linearised and trimmed independently at other speeds than the fit's."""

from __future__ import annotations

import json
from dataclasses import dataclass

import numpy as np
import pytest
import reference_plant as reference
import tomllib
from claims import robust_gain
from conftest import PITCHING
from fly.package import Packages
from fly.stages import ROOT

pytestmark = pytest.mark.change

STATES = [reference.U, reference.W, reference.Q, reference.THETA]
SPEEDS = 60
STEP = 1e-6
"""Of the differences: speeds (m/s), states (SI), outputs in units of their reach. At the trims q|q| bends, q = 0."""


@dataclass
class Design:
    """Plant, ball and numbers of a stored design."""

    certificate: dict
    controller: dict
    figures: dict
    file: dict
    vehicle: reference.Vehicle

    @property
    def plant(self) -> dict[str, np.ndarray]:
        """Generalised plant of the fit."""
        return {key: np.array(rows, float) for key, rows in self.certificate["plant"].items()}

    @property
    def reach(self) -> np.ndarray:
        """Scale of each actuator."""
        return np.array([actuator["scale"] for actuator in self.controller["actuators"]])

    def speeds(self) -> np.ndarray:
        """Return random speeds, and the ends of the range."""
        ends = [self.controller["scheduling"][end] for end in ("minimum", "maximum")]
        return np.append(np.random.default_rng(1).uniform(*ends, SPEEDS), ends)

    def fitted(self, speed: float) -> np.ndarray:
        """Return [A B x0'; 0 0 u0'] of the plant, with its channels closed at the rho of a speed."""
        p, scheduling, (_, right) = self.plant, self.controller["scheduling"], self.place()
        rho = (speed - scheduling["centre"]) / scheduling["half_range"]
        channels = np.hstack([p["Ct"], p["Dt1"], p["Dt2"]])
        closed = np.linalg.solve(np.eye(len(p["Dtt"])) - rho * p["Dtt"], channels)
        rows = np.hstack([p["A"], p["B1"], p["B2"]]) + rho * p["Bt"] @ closed
        whole = np.zeros((4 + len(self.reach), len(right)))
        whole[:4] = rows[:4] @ np.linalg.pinv(right)
        # The only reference that enters the lags is the rate of the trim.
        reference_ = len(p["A"]) + int(np.flatnonzero(right[-1, len(p["A"]) :])[0])
        whole[4:, -1] = self.reach * rows[4 : len(whole), reference_] / right[-1, reference_]
        return whole

    def true(self, speed: float) -> np.ndarray:
        """Return [A B x0'; 0 0 u0'] of the vehicle at a speed, by finite differences of the equations of motion."""
        depth, reach = self.file["model"]["depth"], self.reach
        places, steps = [*STATES, *range(6, 6 + len(reach))], [1.0] * 4 + list(reach)
        here = reference.trim(self.vehicle, speed, depth)

        def rate(y: np.ndarray) -> np.ndarray:
            return reference.rate(self.vehicle, y, y[6:], (0.0, 0.0))[STATES]

        columns = []
        for place, step in zip(places, steps, strict=True):
            moved = np.zeros_like(here)
            moved[place] = step * STEP
            columns.append((rate(here + moved) - rate(here - moved)) / (2.0 * step * STEP))
        after, before = (reference.trim(self.vehicle, speed + side * STEP, depth) for side in (1.0, -1.0))
        slope = (after - before)[places] / (after - before)[reference.U]
        whole = np.zeros((len(places), len(places) + 1))
        whole[:4, :-1], whole[:, -1] = np.array(columns).T, slope
        return whole

    def place(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the factors by which the model enters [A B1 B2]: left, and right, from states, w and u."""
        p, m, reach = self.plant, len(self.reach), self.reach
        n, w = p["B1"].shape
        frequency = self.controller["reference_filter"]
        references = [row for row in self.controller["controller_inputs"] if row["kind"] == "reference"]
        speed = [row["signal"] for row in references].index("speed")
        trim = [i for i in range(n) if p["A"][i, i] == -frequency and p["B1"][i, speed] == frequency]
        assert len(trim) == 1, "the filter of the speed reference is one state"
        left, right = np.zeros((n, 4 + m)), np.zeros((4 + m + 1, n + w + m))
        left[:4, :4] = right[:4, :4] = np.eye(4)
        for j in range(m):
            left[4 + j, 4 + j] = 1.0 / reach[j]
            right[4 + j, 4 + j] = reach[j]
            right[4 + j, n + len(references) + j] = reach[j] * self.file["control"]["disturbance"]
        right[-1] = -references[speed]["scale"] * np.hstack([p["A"], p["B1"], p["B2"]])[trim[0]]
        return left, right


@pytest.fixture
def design(packages: Packages) -> Design:
    folder = packages.controller.parent
    vehicle = PITCHING if packages.vehicle == PITCHING.name else ROOT / "vehicles" / packages.vehicle
    read = [
        json.loads((folder / f"{name}.json").read_text("utf-8"))
        for name in ("certificate", "controller", "design")
    ]
    file = tomllib.loads((vehicle / "design.toml").read_text("utf-8"))
    return Design(*read, file, reference.read_vehicle(vehicle / "vehicle.toml"))


def test_the_fit_has_the_slope_of_the_trims(design: Design) -> None:
    """The slope of the trims in the plant of the proof is that of the vehicle in the reference plant."""
    units = np.append(np.ones(4), design.reach)
    true, found = (
        np.array([of(speed)[:, -1] for speed in design.speeds()]) / units
        for of in (design.true, design.fitted)
    )
    off, largest = np.linalg.norm(found - true, axis=1).max(), np.abs(true[:, 1:]).max()
    assert off < 0.02 * largest, (off, largest)


def test_the_ball_holds_the_vehicle(design: Design) -> None:
    """A Delta of norm at most 1 turns the plant of the fit into that of the vehicle, with its trim and disturbances."""
    ball = {key: np.array(design.certificate["errors"][0][key], float) for key in ("E", "F", "Fw", "Fu")}
    seen = np.hstack([ball["F"], ball["Fw"], ball["Fu"]])
    left, right = design.place()
    sizes, of_slope = [], []
    for speed in design.speeds():
        missed = design.true(speed) - design.fitted(speed)
        alone = missed.copy()
        alone[:, :-1] = 0.0
        for part, to in ((missed, sizes), (alone, of_slope)):
            change = left @ part @ right
            delta = np.linalg.pinv(ball["E"]) @ change @ np.linalg.pinv(seen)
            assert np.abs(ball["E"] @ delta @ seen - change).max() < 1e-9 * np.abs(change).max()
            to.append(np.linalg.norm(delta, 2))
    assert max(sizes) <= 1.0 + 1e-4, "the vehicle is outside"
    assert max(sizes) > 0.8, "the ball is much larger than it must be"
    assert max(of_slope) > 0.1, "the slope takes a part of it"


def test_frozen_gains_of_the_vehicle_are_below_the_bound_of_the_ball(design: Design) -> None:
    """At 101 constant speeds the loop with the true linearisation and slope of the trim is one of the ball's."""
    gain = design.figures["largest_frozen_gain_truth"]
    assert gain < robust_gain(design.certificate)["gamma"], gain
    assert design.figures["gamma_bound_with_model_error"] == robust_gain(design.certificate)["gamma"]
