"""Simulations at sea by the command, and the schema of sea files."""

from __future__ import annotations

import csv
import hashlib
import json
import math
import re
import shutil
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
import tomllib
from conftest import PITCHING, Run, allowed_keys, masked, messages, refusal
from fly.package import Packages
from fly.stages import ROOT
from fmpy import simulate_fmu
from fmpy.fmi1 import FMICallException
from jsonschema import Draft202012Validator
from syrupy.assertion import SnapshotAssertion

pytestmark = pytest.mark.change

BLUEROV = ROOT / "vehicles" / "bluerov2_heavy"
"""No slender hull: it has no [geometry], and is not flown in waves."""
SEA = ROOT / "vehicles" / "sea.toml"
STEP_IS_OVER = 25.0
"""s: of the pitch step in the default flight of REMUS 100."""
XHTML = "{http://www.w3.org/1999/xhtml}"
SCHEMA = json.loads(SEA.with_name("sea.schema.json").read_text(encoding="utf-8"))
VALIDATOR = Draft202012Validator(SCHEMA)


def shipped() -> dict:
    return tomllib.loads(SEA.read_text(encoding="utf-8"))


def toml(value: object) -> str:
    """Return a value in TOML."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {toml(item)}" for key, item in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    return repr(value) if isinstance(value, float) else json.dumps(value)


def complaints(run_squid: Run, folder: Path, sea: dict) -> list[dict]:
    """Return the mistakes in a sea file; none if it is read: BlueROV2 Heavy is not simulated in waves."""
    file = folder / "sea.toml"
    file.write_text("".join(f"{key} = {toml(value)}\n" for key, value in sea.items()), encoding="utf-8")
    done = run_squid("simulate", BLUEROV, "--sea", file, "--out", folder, "--json")
    assert done.returncode == 1
    return json.loads(done.stdout).get("mistakes", [])


def test_the_schema_is_that_of_what_is_shipped() -> None:
    Draft202012Validator.check_schema(SCHEMA)
    VALIDATOR.validate(shipped())


def test_the_keys_are_those_that_are_read(run_squid: Run, tmp_path: Path) -> None:
    tables = {key: table.get("items", table) for key, table in SCHEMA["properties"].items()}
    tables = {"": SCHEMA} | {key: table for key, table in tables.items() if "properties" in table}
    sea = {key: {"zzz": 0} for key in tables if key} | {"zzz": 0, "sensor": [{"zzz": 0}]}
    assert allowed_keys(complaints(run_squid, tmp_path, sea)) == {
        path: set(table["properties"]) for path, table in tables.items()
    }


def numbers() -> list[tuple[str, str, float | int, bool]]:
    """Return numbers at and just beyond the limits of the schema, by table and key, with True for allowed ones."""
    found = []
    tables = {key: table.get("items", table) for key, table in SCHEMA["properties"].items()}
    for table, schema in ({"": SCHEMA} | tables).items():
        for key, number in schema.get("properties", {}).items():
            whole = number.get("type") == "integer"
            for end, side in (("minimum", -1), ("maximum", 1)):
                if end in number:
                    value = number[end] if whole else float(number[end])
                    beyond = value + side if whole else math.nextafter(value, side * math.inf)
                    found += [(table, key, value, True), (table, key, beyond or side * 1e-9, False)]
            if "exclusiveMinimum" in number:
                found.append((table, key, float(number["exclusiveMinimum"]), False))
    return found


@pytest.mark.parametrize(("table", "key", "value", "allowed"), numbers())
def test_the_limits_are_those_that_are_read(
    run_squid: Run, tmp_path: Path, table: str, key: str, value: float, allowed: bool
) -> None:
    sea = shipped()
    sea["waves"]["height"] = 0.01
    place = sea if table == "" else sea[table]
    (place[0] if table == "sensor" else place)[key] = value
    assert (complaints(run_squid, tmp_path, sea) == []) == allowed
    assert VALIDATOR.is_valid(sea) == allowed


@pytest.mark.parametrize(
    ("table", "change"),
    [
        ("waves", {"spectrum": "pierson-moskowitz"}),
        ("waves", {"gamma": None}),
        ("waves", {"spectrum": "bretschneider"}),
        ("current", {"layers": [[0.0, 0.1]]}),
        ("current", {"layers": [[0.0, 0.1, 0.2]], "horizontal": None}),
        ("current", {"layers": [], "horizontal": None}),
        ("gauss_markov", {"mu": None}),
    ],
)
def test_what_excludes_another_is_what_is_read(
    run_squid: Run, tmp_path: Path, table: str, change: dict
) -> None:
    sea = shipped()
    sea[table] = {key: value for key, value in (sea[table] | change).items() if value is not None}
    assert complaints(run_squid, tmp_path, sea)
    assert not VALIDATOR.is_valid(sea)


def test_a_vehicle_without_size_is_not_flown_in_waves(
    run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    done = run_squid("simulate", BLUEROV, "--sea", SEA, "--out", tmp_path, "--json")
    refusal(done, "no_geometry")
    assert messages(done) == snapshot
    assert not any(tmp_path.iterdir())


def test_a_sea_that_is_not_there(run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion) -> None:
    done = run_squid("simulate", BLUEROV, "--sea", tmp_path / "none.toml", "--out", tmp_path, "--json")
    refusal(done, "not_found")
    assert messages(done, TMP=tmp_path) == snapshot


@pytest.fixture(scope="module")
def designed(run_squid: Run, remus100: Packages, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the design of REMUS 100 and its flight in the sea that is shipped."""
    folder = Path(shutil.copytree(remus100.folder, tmp_path_factory.mktemp("remus100") / "out"))
    done = run_squid("simulate", PITCHING, "--sea", SEA, "--out", folder)
    assert done.returncode == 0, done.stderr
    return folder


def test_the_record_is_that_of_the_sea(run_squid: Run, designed: Path) -> None:
    """The surface has the rms of its spectrum, and measurements have bias, quantisation and rate of the sensors."""
    text = (designed / "sea.csv").read_text(encoding="utf-8")
    rows = list(csv.DictReader(text.splitlines()))
    column = {key.split(" ")[0]: np.array([float(row[key]) for row in rows]) for key in rows[0]}
    assert 4.0 * np.std(column["wave_elevation"]) == pytest.approx(1.0, rel=0.2)
    assert 0.01 < np.std(column["current_vertical"]) < 0.2
    assert np.mean(column["current_horizontal"]) == pytest.approx(0.2, abs=0.1)
    bias = np.degrees(column["pitch_read"] - column["pitch"])
    assert np.mean(bias) == pytest.approx(0.2, abs=0.01)
    assert np.std(bias) == pytest.approx(0.05, rel=0.1)
    steps = column["speed_read"] / 0.005
    assert np.allclose(steps, np.round(steps), atol=1e-6)
    assert np.count_nonzero(np.diff(column["speed_read"])) <= 5 * column["time"][-1] + 1

    again = run_squid("simulate", PITCHING, "--sea", SEA, "--out", designed)
    assert again.returncode == 0, again.stderr
    assert (designed / "sea.csv").read_text(encoding="utf-8") == text


def test_a_flight_that_leaves_the_range_of_speed_says_so(
    run_squid: Run, designed: Path, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """A speed log reads 0.3 m/s too high: the autopilot, unaware of it, flies below its range."""
    sea = tmp_path / "sea.toml"
    sea.write_text('seed = 1\n[[sensor]]\nsignal = "speed"\nunit = "m/s"\nbias = 0.3\n', encoding="utf-8")
    folder = Path(shutil.copytree(designed, tmp_path / "out"))
    done = run_squid("simulate", PITCHING, "--sea", sea, "--out", folder, "--json")
    assert done.returncode == 0, done.stderr
    with (folder / "sea.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    speeds = np.array([float(row["speed [m/s]"]) for row in rows])
    heave = np.array([float(row["heave_read [m/s]"]) for row in rows])
    speeds = np.hypot(speeds, heave)
    outside = speeds[speeds < 1.4]
    assert 0 < len(outside) < len(rows)
    # Only the flight in the sea is warned of: with the range, the share of the time, and the speeds outside.
    (warning,) = json.loads(done.stdout)["warnings"]
    assert (warning["kind"], warning["limit"]) == ("outside_speed_range", 1.4)
    assert warning["value"] == pytest.approx(outside.min(), abs=1e-9)
    share = 100.0 * len(outside) / len(rows)
    expected = ["1.4", "2.2", f"{share:.1f}", f"{outside.min():.2f}", f"{outside.max():.2f}"]
    assert re.findall(r"\d+\.\d+", warning["why"])[:5] == expected
    assert masked(warning["why"]) == snapshot


def test_what_is_said_is_what_was_flown(run_squid: Run, designed: Path, tmp_path: Path) -> None:
    found = json.loads(run_squid("simulate", PITCHING, "--sea", SEA, "--out", designed, "--json").stdout)
    assert found["surfacing"] is None
    assert found["at_sea"]["pitch_error"] > found["still_water"]["pitch_error"] > 0.0
    assert (designed / "sea.svg").stat().st_size > 1000

    high = tmp_path / "high.toml"
    high.write_text(SEA.read_text(encoding="utf-8").replace("depth = 10.0", "depth = 1.0"), encoding="utf-8")
    done = run_squid("simulate", PITCHING, "--sea", high, "--out", designed, "--json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["surfacing"] > 0.0


def test_the_fmu_meets_the_same_waves(run_squid: Run, remus100: Packages, tmp_path: Path) -> None:
    """Co-simulation agrees to rounding, model exchange to its integrator's tolerance; neither equals still water."""
    folder = Path(shutil.copytree(remus100.folder, tmp_path / "out"))
    sea = {"seed": 3, "depth": 4.0, "waves": shipped()["waves"] | {"height": 0.5, "heading": 150.0}}
    file = tmp_path / "sea.toml"
    file.write_text("".join(f"{key} = {toml(value)}\n" for key, value in sea.items()), encoding="utf-8")
    done = run_squid("simulate", PITCHING, "--sea", file, "--out", folder)
    assert done.returncode == 0, done.stderr
    rows = list(csv.DictReader((folder / "sea.csv").read_text(encoding="utf-8").splitlines()))
    flown = {key.split(" ")[0]: np.array([float(row[key]) for row in rows]) for key in rows[0]}
    names = ["pitch", "speed", "depth"]
    waves = {
        "initial_depth": sea["depth"],
        "wave_height": sea["waves"]["height"],
        "wave_period": sea["waves"]["period"],
        "wave_gamma": sea["waves"]["gamma"],
        "wave_heading": math.radians(sea["waves"]["heading"]),
        "wave_seed": sea["seed"],
    }

    def off(kind: str, until: float, **values: float) -> float:
        """Return the largest difference from the command's simulation up to a time."""
        interval = flown["time"][1]
        times = flown["time"][flown["time"] <= until]
        result = simulate_fmu(
            str(remus100.loop),
            fmi_type=kind,
            stop_time=times[-1],
            step_size=interval,
            output_interval=interval,
            relative_tolerance=1e-9,
            start_values=values,
            output=names,
        )
        # A step of the integrator may end next to an output point, and events have two rows.
        at = {name: np.interp(times, result["time"], result[name]) for name in names}
        return max(np.max(np.abs(at[name] - flown[name][: len(times)])) for name in names)

    assert off("CoSimulation", flown["time"][-1], **waves) < 1e-12
    assert off("ModelExchange", STEP_IS_OVER, **waves) < 1e-5
    assert off("CoSimulation", STEP_IS_OVER, initial_depth=4.0) > 1e-2
    refused = {"wave_height": 1.0, "wave_period": 2.0}
    with pytest.raises(FMICallException):
        off("CoSimulation", STEP_IS_OVER, **refused)


def test_a_report_has_the_sea_that_is_asked_for(run_squid: Run, quick_vehicle: Path, tmp_path: Path) -> None:
    """A table has six speeds, and the residual waves farther down, which are smaller."""
    sea = shipped()
    sea["waves"]["components"] = 20
    file = tmp_path / "sea.toml"
    file.write_text("".join(f"{key} = {toml(value)}\n" for key, value in sea.items()), encoding="utf-8")
    done = run_squid("report", quick_vehicle, "--sea", file, "--out", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    text = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    page = ET.fromstring(text)
    assert hashlib.sha256(file.read_bytes()).hexdigest() in text
    (section,) = (one for one in page.iter(f"{XHTML}section") if one.get("id") == "sea")
    assert len(list(section.iter(f"{XHTML}tr"))) == 1 + 6
    assert "Hs = 1 m" in "".join(section.itertext()).replace("\u00a0", " ")
    charts = {chart.get("aria-label", ""): chart for chart in section.iter(f"{XHTML}svg")}
    heave = next(chart for label, chart in charts.items() if "rms of heave" in label)
    lines = [line.get("points", "").split() for line in heave.iter(f"{XHTML}polyline")]
    assert len(lines) == 6 and all(len(line) == 4 for line in lines)
    assert all(float(line[0].split(",")[1]) < float(line[-1].split(",")[1]) for line in lines), (
        "y points down"
    )

    refusal(run_squid("report", BLUEROV, "--sea", SEA, "--out", tmp_path / "none", "--json"), "no_geometry")
    assert not (tmp_path / "none").exists()
