"""REMUS 100 with a depth autopilot, from the design file to simulations of its FMUs."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import polars
import pytest
from conftest import REMUS100, Run, kept, masked
from flights import engagement, figures_of, fly_alone, sample_time
from fly.flight import AGREEMENT
from fly.master import Signals, Slave, couple
from fly.package import Packages
from fly.record import differences, references_in
from fmpy import read_model_description
from fmpy.validation import validate_fmu
from squid_campaign import worker
from syrupy.assertion import SnapshotAssertion

pytestmark = pytest.mark.change

DESIGN = ["--axis", "depth"]


@pytest.fixture(scope="module")
def deep(run_squid: Run) -> Packages:
    return kept(run_squid, REMUS100, *DESIGN)


@pytest.fixture(scope="module")
def flown(deep: Packages) -> Signals:
    return fly_alone(
        deep.loop, json.loads((deep.folder / "manoeuvre.json").read_text())["duration"], sample_time(deep)
    )


def inputs_of(fmu: Path) -> set[str]:
    """Return the inputs of an FMU."""
    variables = read_model_description(fmu).modelVariables
    flown = ("step", "ramp", "speed_from", "speed_to")
    return {
        v.name for v in variables if v.causality == "input" or v.name.startswith(flown) or "_step" in v.name
    }


def test_what_is_asked_is_met_and_proved(deep: Packages) -> None:
    design = json.loads((deep.folder / "design.json").read_text(encoding="utf-8"))
    rows = {row["what"]: row for row in design["verdict"]["rows"]}
    assert design["certified"] is True
    assert [row["what"] for row in rows.values() if row["outcome"] == "missed"] == []
    assert {"overshoot", "depth_rise", "steady_error"} <= {row["key"] for row in rows.values()}
    assert not [what for what in rows if what.startswith("pitch")]


def test_the_step_at_the_limits_is_one_of_the_depth(deep: Packages, run_squid: Run) -> None:
    words = ["verify", deep.controller, "--vehicle", REMUS100, *DESIGN]
    done = run_squid(*words, "--json")
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["pitch_step_deg"] is None and found["depth_step_m"] > 0.5
    (said,) = re.findall(
        r"depth reference.*? ([\d.]+) m\.", " ".join(run_squid(*words, "--verbose").stdout.split())
    )
    assert float(said) == found["depth_step_m"]


def test_the_fmus_take_a_depth_and_no_step_of_pitch(deep: Packages, snapshot: SnapshotAssertion) -> None:
    for fmu in deep.fmus:
        assert validate_fmu(str(fmu)) == []
    references = {"depth_reference", "speed_reference"}
    assert inputs_of(deep.controller) == {
        "depth",
        "pitch",
        "pitch_rate",
        "speed",
        *references,
        *engagement(deep),
    }
    course = {"depth_step", "step_time", "step_end", "speed_from", "speed_to", "ramp_start", "ramp_duration"}
    outside = {"current_horizontal", "current_vertical"}
    outside |= {"external_force_x", "external_force_z", "external_moment"}
    assert inputs_of(deep.loop) == {"manual", *references, *course, *outside}
    names = {v.name for v in read_model_description(deep.loop).modelVariables}
    assert "depth_reference_used" in names
    described = [masked(read_model_description(fmu).description) for fmu in (deep.controller, deep.loop)]
    assert "\n".join(described) == snapshot
    assert {name for name in names if name.startswith("pitch_")} == {"pitch_rate"}


def test_the_depth_is_held_and_followed(
    deep: Packages, flown: Signals, run_squid: Run, tmp_path: Path
) -> None:
    """Depth step while the speed ramps through the range; the coupled simulation agrees."""
    figures = figures_of(run_squid, flown, tmp_path)
    assert "pitch_steps" not in figures
    # The step of 1 m is used as a ramp, which counts as a step to its final value.
    (step,) = figures["depth_steps"]
    assert step["height"] == pytest.approx(1.0) and step["time"] == pytest.approx(10.0)
    assert step["overshoot"] < 0.02 and 0.0 < step["settling_time"] < 30.0
    begin = np.searchsorted(
        flown["time"], json.loads((deep.folder / "manoeuvre.json").read_text())["step_time"]
    )
    used = flown["depth_reference_used"]
    assert used[begin] == 20.0 and used[-1] == 21.0
    assert 1.0 < sample_time(deep) * np.count_nonzero((used > 20.0) & (used < 21.0)) < 2.0
    assert np.max(flown["depth"]) < 21.02 and flown["depth"][-1] == pytest.approx(21.0, abs=1e-3)
    assert figures["speed_error"] < 0.1
    with Slave(deep.plant, "plant") as plant, Slave(deep.controller, "controller") as controller:
        plant.begin({"initial_speed": 1.5})
        controller.begin()
        end = float(flown["time"][-1])
        coupled = couple(plant, controller, references_in(flown), end, sample_time(deep))
    assert max(differences(flown, coupled).values()) <= AGREEMENT


def test_the_worker_of_a_campaign_flies_the_same(deep: Packages, flown: Signals) -> None:
    """The record contains the depth reference."""
    drawn = {
        "manoeuvre": json.loads((deep.folder / "manoeuvre.json").read_text()),
        "start": {},
        "gains": None,
    }
    rows: list[list[float]] = []
    with Slave(deep.plant, "plant") as plant, Slave(deep.controller, "controller") as controller:
        followed = worker.wanted_by(controller)
        worker.fly(plant, controller, drawn, rows)
    assert followed == ["pitch_reference", "depth_reference", "speed_reference"]
    record = dict(
        zip(["time", *worker.WATCHED, *(f"{name}_used" for name in followed)], np.array(rows).T, strict=False)
    )
    for name in ("time", "pitch", "speed", "depth", "distance"):
        assert record[name] == pytest.approx(flown[name], abs=AGREEMENT), name
    # The reference of a tick is in the following row; on the way it stays within the envelope of the vehicle.
    asked, used = record["depth_reference_used"][:-1], flown["depth_reference_used"][1:]
    on_the_way = np.abs(asked - used) > AGREEMENT
    assert set(asked) == {20.0, 21.0} and 0 < np.count_nonzero(on_the_way) < 2.0 / sample_time(deep)
    assert np.all((used >= 20.0) & (used <= 21.0)) and np.all(asked[on_the_way] == 21.0)


def test_a_flight_does_not_depend_on_the_depth_where_it_begins(deep: Packages, flown: Signals) -> None:
    """The result is the same within the rounding of depths, which are larger than the distance moved."""
    lower = fly_alone(deep.loop, 40.0, sample_time(deep), {"initial_depth": 300.0})
    count = len(lower["time"])
    for name in ("pitch", "stern_planes", "propeller"):
        assert lower[name] == pytest.approx(flown[name][:count], abs=1e-9)
    assert lower["depth"] - 300.0 == pytest.approx(flown["depth"][:count] - 20.0, abs=1e-9)


def test_another_reference_at_the_start_is_a_step(deep: Packages, flown: Signals) -> None:
    """As in the SSP, the response equals that to the step that comes later, at the same speed."""
    values = {"speed_to": 1.5, "step_time": 0.0}
    early = fly_alone(deep.loop, 40.0, sample_time(deep), values)
    late = fly_alone(deep.loop, 50.0, sample_time(deep), values | {"step_time": 10.0})
    begin = round(10.0 / sample_time(deep))
    count = len(early["time"])
    assert early["depth"] == pytest.approx(late["depth"][begin : begin + count], abs=1e-6)
    assert early["stern_planes"][1:] == pytest.approx(
        late["stern_planes"][begin + 1 : begin + count], abs=1e-6
    )


def test_a_ramp_is_followed_by_hand(deep: Packages) -> None:
    """Down by 6 m at 0.1 m/s while `manual` is true: at most 5 s behind, and on the reference at the end."""
    tick = sample_time(deep)

    def inputs(time: float) -> dict[str, float]:
        wanted = 20.0 + 0.1 * min(max(time - 5.0, 0.0), 60.0)
        return {"manual": True, "depth_reference": wanted, "speed_reference": 1.8}

    flown = fly_alone(deep.loop, 110.0, tick, {"speed_from": 1.8}, inputs)
    error = flown["depth_reference_used"] - flown["depth"]
    assert flown["tracking_error"] == pytest.approx(error, abs=0.1 * tick + 1e-9)
    assert np.max(np.abs(error)) < 0.1 * 7.0 and abs(error[-1]) < 5e-3
    assert np.max(np.abs(flown["pitch"] - flown["trim_pitch"])) < np.deg2rad(8.0)


def test_campaigns_draw_steps_of_the_depth(deep: Packages, run_squid: Run, tmp_path: Path) -> None:
    words = [
        "--flights",
        "16",
        "--starts",
        "depth=0.2m",
        "--no-bound",
        "--out",
        deep.folder.parent,
        "--to",
        tmp_path,
    ]
    done = run_squid("campaign", REMUS100, *DESIGN, *words, timeout=900.0)
    assert done.returncode == 0, done.stderr
    flights = polars.read_parquet(tmp_path / "*.parquet")
    assert {abs(step) for step in flights["depth_step"]} == {1.0} and len(set(flights["depth_step"])) == 2
    assert 0.1 < flights["depth_off_trim"].abs().max() <= 0.2
    assert flights["outcome"].to_list() == ["flown"] * 16
    assert 0.0 < flights["depth_error_rms"].max() < 0.6
    assert "pitch_error_rms" not in flights.columns
    page = (tmp_path / "campaign.html").read_text(encoding="utf-8")
    assert "depth step" in page and "pitch step" not in page
