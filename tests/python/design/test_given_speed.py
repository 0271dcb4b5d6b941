"""A vehicle with prescribed speed: NPS AUV II in heave and pitch, from its file to its FMUs."""

from __future__ import annotations

import json
import re
import shutil
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import tomllib
from conftest import PITCHING, Run, kept, masked, messages, refusal, reported
from flights import engagement, fly_alone, sample_time
from fly.flight import AGREEMENT
from fly.master import Slave, couple
from fly.package import Packages
from fly.record import differences, references_in
from fly.stages import ROOT
from fmpy.validation import validate_fmu
from scipy.integrate import solve_ivp
from syrupy.assertion import SnapshotAssertion

pytestmark = pytest.mark.change

NPS = ROOT / "tests" / "vehicles" / "nps_auv_ii"
LAG = 2.0


@pytest.fixture(scope="session")
def nps(run_squid: Run) -> Packages:
    return kept(run_squid, NPS)


class DivePlane:
    """Heave and pitch of NPS AUV II, written manually from Healey and Lienard (1993) with cross-flow drag by strips.

    The combined lift includes the Munk moment. The speed u follows the prescribed one with a lag and acts on pitch by
    `m z_G u'`.
    """

    def __init__(self) -> None:
        self.r2, r3, r4, r5 = (0.5 * 1025.0 * 5.3**power for power in (2, 3, 4, 5))
        self.m, self.weight, self.z_g = 5454.54, 53400.0, 0.061
        self.mass = np.array([[self.m + 0.24 * r3, 6.8e-3 * r4], [6.8e-3 * r4, 13587.0 + 0.017 * r5]])
        self.z_w, self.z_q = -0.3 * self.r2, -0.14 * r3
        self.m_w, self.m_q = 0.1 * r3, -0.068 * r4
        self.z_d, self.m_d = -0.073 * self.r2, -0.041 * r3
        nodes, weights = np.polynomial.legendre.leggauss(200)
        self.x, self.drag = 2.65 * nodes, 0.5 * 1025.0 * 0.6 * 0.53 * 2.65 * weights

    def cross_flow(self, w: float, q: float) -> np.ndarray:
        """Return heave force and pitch moment of a block of 5.3 m by 0.53 m."""
        drag = self.drag * (w - self.x * q) * np.abs(w - self.x * q)
        return np.array([-np.sum(drag), np.sum(self.x * drag)])

    def rate(self, state: np.ndarray, given: float, delta: float) -> np.ndarray:
        """Return u', w', q' and theta' at a prescribed speed and a deflection."""
        u, w, q, theta = state
        surge = (given - u) / LAG
        heave = self.z_w * u * w + (self.m + self.z_q) * u * q + self.m * self.z_g * q * q
        pitch = self.m_w * u * w + self.m_q * u * q - self.m * self.z_g * w * q
        planes = np.array([self.z_d, self.m_d]) * u * abs(u) * delta
        righting = np.array([0.0, self.z_g * self.weight * np.sin(theta)])
        inertia = np.array([0.0, self.m * self.z_g * surge])
        force = np.array([heave, pitch]) + self.cross_flow(w, q) + planes - righting - inertia
        return np.array([surge, *np.linalg.solve(self.mass, force), q])


def test_the_linear_model_is_that_of_the_dive_plane(run_squid: Run) -> None:
    done = run_squid("show", NPS, "--speed", "1.5", "--json")
    found = json.loads(done.stdout)["at_speed"]
    assert found["states"] == ["w", "q", "theta"]
    plane, step = DivePlane(), 1e-6
    level = np.array([1.5, 0.0, 0.0, 0.0])
    for place in range(3):
        moved = np.zeros(4)
        moved[place + 1] = step
        slope = (plane.rate(level + moved, 1.5, 0.0) - plane.rate(level - moved, 1.5, 0.0)) / (2.0 * step)
        assert np.array(found["A"])[:, place] == pytest.approx(slope[1:], abs=1e-6)
    slope = (plane.rate(level, 1.5, step) - plane.rate(level, 1.5, -step)) / (2.0 * step)
    assert np.array(found["B"])[:, 0] == pytest.approx(slope[1:], abs=1e-9)


def test_the_plant_moves_as_the_dive_plane(nps: Packages) -> None:
    """Step of the planes with a change of the prescribed speed, compared with an independent integration."""
    plane, delta, given = DivePlane(), 0.1, 2.1
    start = [1.2, 0.0, 0.0, 0.0]
    expected = solve_ivp(
        lambda time, state: plane.rate(state, given, delta * (1.0 - np.exp(-time / 0.1))),
        (0.0, 20.0),
        start,
        rtol=1e-9,
        atol=1e-11,
        t_eval=[5.0, 10.0, 20.0],
        max_step=0.05,
    ).y
    with Slave(nps.plant, "plant") as plant:
        plant.begin({"initial_speed": 1.2})
        plant.ready()
        plant.set("stern_planes", delta)
        plant.set("given_speed", given)
        for column, time in enumerate((5.0, 10.0, 20.0)):
            plant.step_to(time)
            found = [plant.get(name) for name in ("speed", "heave", "pitch_rate", "pitch")]
            assert found == pytest.approx(expected[:, column], abs=2e-5), time
    assert abs(expected[3, -1]) > 0.2 and expected[0, -1] > 2.09


def test_the_interfaces_know_whose_the_speed_is(nps: Packages) -> None:
    """The plant takes the speed as an input, the controller only measures it; all required connections exist."""
    for fmu in (nps.plant, nps.controller, nps.loop):
        assert not validate_fmu(str(fmu))
    with Slave(nps.plant, "plant") as plant, Slave(nps.controller, "controller") as controller:
        assert set(plant.names("input")) == {
            "stern_planes",
            "current_horizontal",
            "current_vertical",
            "external_force_z",
            "external_moment",
            "operating_speed",
            "given_speed",
        }
        assert set(controller.names("input")) - engagement(nps) == {
            "pitch",
            "speed",
            "pitch_rate",
            "pitch_reference",
        }
        assert "speed" in plant.names("output")
        # Loads along the hull have no effect, and are not parameters.
        parameters = set(plant.names("parameter"))
        assert {"mass", "Z_uw", "M_uq"} <= parameters and not parameters & {"X_u", "X_uu", "drag_area"}
        plant.begin()
        controller.begin()
        plant.ready()
        controller.ready()


@pytest.mark.parametrize("fidelity", [1, 2])
def test_coupled_is_the_same_flight(nps: Packages, fidelity: int) -> None:
    loop = fly_alone(nps.loop, 60.0, sample_time(nps), {"fidelity": fidelity})
    with Slave(nps.plant, "plant") as plant, Slave(nps.controller, "controller") as controller:
        plant.begin({"initial_speed": float(loop["path_speed"][0]), "fidelity": fidelity})
        controller.begin()
        coupled = couple(plant, controller, references_in(loop), float(loop["time"][-1]), sample_time(nps))
    found = differences(loop, coupled)
    assert {"pitch", "speed", "depth", "stern_planes"} <= set(found)
    assert max(found.values()) <= AGREEMENT, found
    # A pitch step of 3 degrees is held, while the prescribed speed went from 1.1 to 2.1 m/s.
    assert loop["pitch"][-1] == pytest.approx(np.radians(3.0), abs=1e-3)
    assert (loop["speed"][0], loop["speed"][-1]) == pytest.approx((1.1, 2.1), abs=1e-6)
    # The ramp of 1 m/s in 30 s is followed with the delay of the lag.
    behind = loop["speed_reference_used"] - loop["speed"]
    assert behind.max() == pytest.approx(LAG / 30.0, rel=0.05)


def test_the_proof_is_of_this_vehicle(run_squid: Run, nps: Packages) -> None:
    # The scale of the pitch is verified only with the vehicle's files.
    certificate = nps.folder / "certificate.json"
    of = ("--vehicle", NPS)
    runs = [(nps.loop, *of), (certificate, *of), (nps.loop,), (certificate,)]
    found = [json.loads(run_squid("verify", *run, "--json").stdout)["pitch_step_deg"] for run in runs]
    assert found[0] == found[1] and found[2:] == [None, None]
    assert 3.0 < found[0] < 90.0
    done = run_squid("verify", nps.loop, "--vehicle", NPS, "--verbose")
    assert done.returncode == 0 and f" {found[0]} deg" in done.stdout, done.stderr
    assert run_squid("verify", nps.loop, "--vehicle", PITCHING).returncode == 1


def test_the_report_speaks_of_the_given_speed(run_squid: Run, snapshot: SnapshotAssertion) -> None:
    page = reported(run_squid, NPS)
    captions = re.findall(r"<figcaption>(.*?)</figcaption>", page)
    assert "\n".join(masked(one) for one in captions if "given" in one) == snapshot
    assert "speed reference" not in page and "NaN" not in page
    assert "x = [w q theta]" in page
    (peers,) = re.findall(r'<section id="peers">(.*?)</section>', page, re.DOTALL)
    head, *rows = re.findall("<tr>(.*?)</tr>", peers)
    assert ">PID</th>" in head and not [
        row for row in rows if row.startswith(("<td>speed", '<td class="words">speed'))
    ]


def test_a_variant_of_the_system_starts_at_the_speed_that_it_gives(nps: Packages) -> None:
    (system,) = nps.loop.parent.glob("*.ssp")
    with zipfile.ZipFile(system) as archive:
        sets = [name for name in archive.namelist() if re.fullmatch(r"resources/plant_speed_.*\.ssv", name)]
        assert len(sets) == 6
        for name in sets:
            root = ElementTree.fromstring(archive.read(name))
            space = "{http://ssp-standard.org/SSP1/SystemStructureParameterValues}"
            values = {one.get("name"): float(one[0].get("value")) for one in root.iter(f"{space}Parameter")}
            assert values["given_speed"] == pytest.approx(values["initial_speed"], abs=1e-9)
        structure = archive.read("SystemStructure.ssd").decode()
    wires = re.findall(r'startConnector="(\w+)"', structure)
    assert set(wires) == {"pitch", "speed", "pitch_rate", "stern_planes"}


SPEED_TRACK = """
[[track]]
output = "speed"
scale = 0.3
unit = "m/s"
peak = 2.0
steady_error = 0.004
bandwidth = 0.2
frequency = 0.65
"""
SPEED_MEASURED = """
[[measure]]
signal = "speed"
scale = 0.3
unit = "m/s"
noise = 0.001
"""


@pytest.mark.parametrize(
    "more",
    [SPEED_TRACK, SPEED_MEASURED, "\n[require]\nspeed_rise = 3.0\n"],
    ids=["track", "measure", "require"],
)
def test_a_design_may_not_ask_for_the_speed(
    run_squid: Run, tmp_path: Path, more: str, snapshot: SnapshotAssertion
) -> None:
    vehicle = shutil.copytree(NPS, tmp_path / "nps")
    with (vehicle / "design.toml").open("a", encoding="utf-8") as design:
        design.write(more)
    done = run_squid("design", vehicle, "--no-advise", "--out", tmp_path / "out", "--json")
    refusal(done, "given_speed")
    assert messages(done, TMP=tmp_path) == snapshot
    assert not (tmp_path / "out").exists()


def test_a_first_design_file_tracks_pitch_alone(run_squid: Run, tmp_path: Path) -> None:
    vehicle = tmp_path / "nps"
    vehicle.mkdir()
    shutil.copy(NPS / "vehicle.toml", vehicle)
    done = run_squid("tune", vehicle, "--designs", "3", "--track", "pitch", timeout=600.0)
    assert (vehicle / "design.toml").exists(), done.stderr
    design = tomllib.loads((vehicle / "design.toml").read_text(encoding="utf-8"))
    assert [one["output"] for one in design["track"]] == ["pitch"]
    assert [one["signal"] for one in design["measure"]] == ["pitch", "pitch_rate"]
