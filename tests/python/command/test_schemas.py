"""JSON schemas of a vehicle's files, with which editors check them, agree with the parsers of these files."""

from __future__ import annotations

import copy
import json
import math
import re
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
import tomllib
from conftest import SQUID, Run, allowed_keys
from fly.stages import ROOT
from jsonschema import Draft202012Validator

pytestmark = pytest.mark.change

VEHICLES = ROOT / "vehicles"
SCHEMAS = {name: json.loads((VEHICLES / f"{name}.schema.json").read_text()) for name in ("vehicle", "design")}


def toml(value: object) -> str:
    """Return a value in TOML."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{json.dumps(key)} = {toml(item)}" for key, item in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    return repr(value) if isinstance(value, float) else json.dumps(value)


def written(content: dict) -> str:
    """Return the text of a file, one section per line."""
    return "".join(f"{json.dumps(key)} = {toml(value)}\n" for key, value in content.items())


def complaints(run_squid: Run, folder: Path, name: str, content: dict) -> list[dict]:
    """Return the mistakes that `squid show` finds in one of the files of Squid, which is replaced.

    A wrong `design.toml` does not stop it; a design that is named does.
    """
    shutil.copytree(SQUID, folder, dirs_exist_ok=True)
    file = {"vehicle": "vehicle", "design": "named"}[name]
    (folder / f"{file}.toml").write_text(written(content), encoding="utf-8")
    named = [] if file == "vehicle" else ["--design", file]
    return mistakes_in(f"{file}.toml", run_squid("show", folder, "--speed", "1.7", *named, "--json"))


def mistakes_in(file: str, done: subprocess.CompletedProcess) -> list[dict]:
    """Return the mistakes in a file; an error that is no mistake at a line counts as one."""
    answer = json.loads(done.stdout)
    return answer.get("mistakes", [answer]) if f"{file}:" in answer.get("reason", "") else []


def keys_of(found: list[dict]) -> set[str]:
    return {mistake["key"] for mistake in found if "key" in mistake}


def example(name: str) -> dict:
    return tomllib.loads((SQUID / f"{name}.toml").read_text(encoding="utf-8"))


def tables(schema: dict, path: str = "") -> Iterator[tuple[str, dict]]:
    """Yield each table of fixed keys in a schema with its path; an array of tables has the path of the table."""
    inner = schema.get("items", schema)
    if inner.get("additionalProperties") is False:
        yield path, inner
        for key, value in inner["properties"].items():
            # An axis has the tables of the file.
            if key != "axis":
                yield from tables(value, f"{path}.{key}".lstrip("."))


def with_unknown_keys(schema: dict) -> object:
    """Return an instance in which every table has one unknown key in addition to its tables."""
    inner = schema.get("items", schema)
    found = {
        key: with_unknown_keys(value)
        for key, value in inner["properties"].items()
        if value.get("items", value).get("additionalProperties") is False and key != "axis"
    } | {"zzz": 0}
    return [found] if "items" in schema else found


@pytest.mark.parametrize(
    "path", sorted(VEHICLES.glob("*/*.toml")), ids=lambda path: f"{path.parent.name}/{path.name}"
)
def test_what_is_shipped_is_valid(path: Path) -> None:
    schema = SCHEMAS["vehicle" if path.name == "vehicle.toml" else "design"]
    Draft202012Validator(schema).validate(tomllib.loads(path.read_text(encoding="utf-8")))


@pytest.mark.parametrize("name", SCHEMAS)
def test_the_keys_are_those_that_are_read(run_squid: Run, tmp_path: Path, name: str) -> None:
    unknown = with_unknown_keys(SCHEMAS[name])
    said = complaints(run_squid, tmp_path, name, unknown)
    if name == "design":
        # Keys of the other axes.
        for output in ("heading", "roll"):
            unknown["track"] = [{"output": output, "zzz": 0}]
            unknown["controller"] = {"kind": "pid", output: {"zzz": 0}, "allocation": {"zzz": 0}, "zzz": 0}
            said += complaints(run_squid, tmp_path, name, unknown)
    read = allowed_keys([mistake for mistake in said if mistake["key"].endswith("zzz")])
    for angle in ("heading", "roll") if name == "design" else ():
        assert read.pop(f"controller.{angle}") == read["controller.pitch"] - {"feedforward"}
    known = {path: set(table["properties"]) for path, table in tables(SCHEMAS[name])}
    assert read == known


def limits(schema: dict) -> Iterator[tuple[float, bool]]:
    """Yield numbers at and just beyond the limits, with True for those that are allowed."""
    for key, side in (("minimum", -math.inf), ("maximum", math.inf)):
        if key in schema:
            yield float(schema[key]), True
            yield math.nextafter(float(schema[key]), side) or math.copysign(1e-9, side), False
    for key in ("exclusiveMinimum", "exclusiveMaximum"):
        if key in schema:
            yield float(schema[key]), False


SEA = {"depth": 2.0, "spectrum": "jonswap", "height": 1e-3, "period": 5.0, "gamma": 3.3, "heading": 180.0}
"""A table [sea] of waves that no period makes too steep."""
PID = {"kind": "pid", "pitch": {"kp": {"value": 100.0, "unit": "N.m/rad"}}}
OWN = {"sea": SEA, "controller": PID, "envelope": {"unit": "deg"}, "failsafe": {}}
"""What a section that Squid's design does not have must hold."""
NUMBERS = [
    (section, key, value, allowed)
    for section, schema in SCHEMAS["design"]["properties"].items()
    for key, number in schema.get("items", schema).get("properties", {}).items()
    if number.get("type") == "number" and key not in ("delay", "turn_rate")
    for value, allowed in limits(number)
]


@pytest.mark.parametrize(("section", "key", "value", "allowed"), NUMBERS)
def test_the_limits_of_a_design_are_those_that_are_read(
    run_squid: Run, tmp_path: Path, section: str, key: str, value: float, allowed: bool
) -> None:
    design = example("design")
    table = design.setdefault(section, dict(OWN.get(section, {})))
    # The scale of a pitch has limits of its own; that of the speed may be any number.
    place = 1 if (section, key) == ("track", "scale") else 0
    table = table[place] if isinstance(table, list) else table
    table[key] = value
    refused = f"{section}.{key}" in keys_of(complaints(run_squid, tmp_path, "design", design))
    assert refused != allowed
    assert Draft202012Validator(SCHEMAS["design"]).is_valid(design) == allowed


@pytest.mark.parametrize(
    ("scale", "unit", "allowed"),
    [
        (89.9, "deg", True),
        (90.1, "deg", False),
        (1.57, "rad", True),
        (1.58, "rad", False),
        (5.0, "rad", False),
    ],
)
def test_a_pitch_is_off_by_a_right_angle_at_most(
    run_squid: Run, tmp_path: Path, scale: float, unit: str, allowed: bool
) -> None:
    design = example("design")
    design["track"][0] |= {"scale": scale, "unit": unit}
    assert ("track.scale" in keys_of(complaints(run_squid, tmp_path, "design", design))) != allowed
    assert Draft202012Validator(SCHEMAS["design"]).is_valid(design) == allowed


STEP = {"pitch_step": 5.0, "unit": "deg"}


@pytest.mark.parametrize(
    ("outputs", "steps", "allowed"),
    [
        (["pitch"], STEP, True),
        (["pitch"], STEP | {"depth_step": 1.0}, False),
        (["pitch"], {}, False),
        (["depth"], {"depth_step": -1.0}, True),
        (["depth"], {}, False),
        (["depth"], {"depth_step": 0.5} | STEP, False),
        (["depth"], {"depth_step": 0.5, "unit": "deg"}, False),
        (["pitch", "depth"], {"depth_step": 0.5} | STEP, True),
        (["pitch", "depth"], {"depth_step": 0.5}, False),
        (["pitch", "depth"], STEP, False),
    ],
)
def test_steps_are_of_what_is_tracked(
    run_squid: Run, tmp_path: Path, outputs: list[str], steps: dict, allowed: bool
) -> None:
    design = example("design")
    depth = design["track"][0] | {"output": "depth", "scale": 1.0, "unit": "m"}
    own = {"pitch": design["track"][0], "depth": depth}
    design["track"] = [own[output] for output in outputs] + design["track"][1:]
    others = {key: value for key, value in design["manoeuvre"].items() if key not in STEP}
    design["manoeuvre"] = others | steps
    assert bool(complaints(run_squid, tmp_path, "design", design)) != allowed
    assert Draft202012Validator(SCHEMAS["design"]).is_valid(design) == allowed


@pytest.mark.parametrize(
    ("envelope", "allowed"),
    [
        ({}, True),
        ({"authority": 0.5}, True),
        ({"pitch": [-10, 5.0], "unit": "deg"}, True),
        ({"pitch": [-10.0, 5.0]}, False),
        ({"path_angle": 20.0}, False),
        ({"pitch": [-60.0, 60.0], "unit": "deg"}, True),
        ({"pitch": [-61.0, 5.0], "unit": "deg"}, False),
        ({"pitch": [-1.0, 1.0], "path_angle": 0.5, "unit": "rad"}, True),
        ({"pitch": [-1.0, 1.1], "unit": "rad"}, False),
        ({"path_angle": 20.0, "unit": "rad"}, False),
        ({"pitch": 5.0, "unit": "deg"}, False),
        ({"pitch": [-10.0, 0.0, 5.0], "unit": "deg"}, False),
        ({"pitch": [-10.0, 5.0], "unit": "m"}, False),
    ],
)
def test_an_envelope_is_one_that_is_read(
    run_squid: Run, tmp_path: Path, envelope: dict, allowed: bool
) -> None:
    design = example("design") | {"envelope": envelope}
    found = keys_of(complaints(run_squid, tmp_path, "design", design))
    assert any(key.startswith("envelope.") for key in found) != allowed
    assert Draft202012Validator(SCHEMAS["design"]).is_valid(design) == allowed


HEADING = {
    "track": [{"output": "heading", "scale": 10.0, "unit": "deg"}],
    "measure": [{"signal": "heading", "scale": 10.0, "unit": "deg", "noise": 0.003}],
    "manoeuvre": {"heading_step": 10.0, "unit": "deg"},
}
"""What a design of heading has of its own, added to that of Squid."""


@pytest.mark.parametrize(
    ("changes", "allowed"),
    [
        ({}, True),
        ({"envelope": {"turn_rate": 8.0, "unit": "deg"}}, True),
        ({"envelope": {"turn_rate": 90.0, "unit": "deg"}}, True),
        ({"envelope": {"turn_rate": 91.0, "unit": "deg"}}, False),
        ({"envelope": {"turn_rate": 0.0, "unit": "deg"}}, False),
        ({"envelope": {"turn_rate": 1.6, "unit": "rad"}}, False),
        ({"envelope": {"turn_rate": 8.0}}, False),
        ({"envelope": {"authority": 0.5}}, False),
        ({"sea": SEA}, False),
        ({"manoeuvre": {"pitch_step": 5.0, "unit": "deg"}}, False),
        ({"measure": [{"signal": "pitch", "scale": 5.0, "unit": "deg", "noise": 0.01}]}, False),
        ({"measure": [{"signal": "heading_rate", "scale": 10.0, "unit": "deg", "noise": 0.5}]}, False),
        (
            {"measure": HEADING["measure"] + [{"signal": "roll", "scale": 5.0, "unit": "deg", "noise": 0.1}]},
            True,
        ),
    ],
)
def test_a_design_of_heading_is_one_that_is_read(
    run_squid: Run, tmp_path: Path, changes: dict, allowed: bool
) -> None:
    design = example("design")
    del design["uncertainty"]
    others = {key: value for key, value in design["manoeuvre"].items() if key not in STEP}
    wanted = HEADING | changes
    design |= wanted | {"track": [design["track"][0] | HEADING["track"][0]]}
    design["manoeuvre"] = others | wanted["manoeuvre"]
    shutil.copytree(VEHICLES / "remus100", tmp_path, dirs_exist_ok=True)
    (tmp_path / "named.toml").write_text(written(design), encoding="utf-8")
    done = run_squid("show", tmp_path, "--speed", "1.7", "--design", "named", "--json")
    assert bool(mistakes_in("named.toml", done)) != allowed, done.stderr
    assert Draft202012Validator(SCHEMAS["design"]).is_valid(design) == allowed


def test_the_defaults_of_requirements_are_those_of_the_verdict(run_squid: Run, quick_vehicle: Path) -> None:
    """A design without `[require]` or `[uncertainty]` gets the defaults; without a speed loop, none of the speed."""
    done = run_squid(
        "design", quick_vehicle, "--no-advise", "--json", "--out", quick_vehicle.parent / "limits"
    )
    rows = json.loads(done.stdout)["design"]["verdict"]["rows"]
    limits = {row["key"]: row["limit"] for row in rows if row.get("limit") is not None}
    keys = SCHEMAS["design"]["properties"]["require"]["properties"]
    said = {
        key: re.search(r"; ([\d.]+) where it is left out", one["description"]) for key, one in keys.items()
    }
    defaults = {key: float(found[1]) for key, found in said.items() if found}
    assert {"beyond_recovery", "delay_margin"} <= limits.keys()
    # The quick vehicle sets one limit itself.
    assert limits.pop("beyond_recovery") != defaults["beyond_recovery"]
    not_here = ("mu", "corner_overshoot", "beyond_speed", "held_speed", "beyond_recovery")
    assert limits == {key: limit for key, limit in defaults.items() if key not in not_here}


CURVE = {"unit": "%", "source": "a test", "value": [[-100.0, -80.0], [100.0, 120.0]]}
SQUARE = {"value": 1e-4, "unit": "N/rpm2", "source": "a test"}


@pytest.mark.parametrize(
    ("keys", "allowed"),
    [
        ({"curve": CURVE}, True),
        ({"T_nn": SQUARE}, True),
        ({"curve": CURVE, "min": None, "max": None}, True),
        ({"T_nn": SQUARE, "min": None}, False),
        ({"curve": CURVE, "T_nn": SQUARE}, False),
        ({"curve": {**CURVE, "unit": "ms"}}, False),
        ({"curve": {**CURVE, "value": [[0.0, 0.0]]}}, False),
        ({"T_nn": {**SQUARE, "value": 0.0}}, False),
        ({"T_nn": {**SQUARE, "unit": "N"}}, False),
    ],
)
def test_curves_are_those_that_are_read(run_squid: Run, tmp_path: Path, keys: dict, allowed: bool) -> None:
    vehicle = example("vehicle")
    thruster = vehicle["thruster"][0] | keys
    vehicle["thruster"][0] = {key: value for key, value in thruster.items() if value is not None}
    assert bool(complaints(run_squid, tmp_path, "vehicle", vehicle)) != allowed
    assert Draft202012Validator(SCHEMAS["vehicle"]).is_valid(vehicle) == allowed


def number(value: float, unit: str) -> dict:
    """Return a number of a vehicle file."""
    return {"value": value, "unit": unit, "source": "a test"}


@pytest.mark.parametrize(
    ("keys", "allowed"),
    [
        ({"rate": number(40.0, "N/s")}, True),
        ({"rate": number(0.0, "N/s")}, False),
        ({"rate": number(40.0, "N")}, False),
        ({"rate": number(40.0, "deg/s")}, False),
        ({"rate": number(40.0, "N/s"), "lag": number(0.0, "s")}, False),
        ({"lag": number(0.0, "s")}, True),
    ],
)
def test_a_rate_is_one_that_is_read(run_squid: Run, tmp_path: Path, keys: dict, allowed: bool) -> None:
    vehicle = example("vehicle")
    vehicle["thruster"][0] |= keys
    assert bool(complaints(run_squid, tmp_path, "vehicle", vehicle)) != allowed
    assert Draft202012Validator(SCHEMAS["vehicle"]).is_valid(vehicle) == allowed


RUDDER = {"Y_uu_delta": number(10.0, "kg/(m.rad)"), "N_uu_delta": number(-8.0, "kg/rad")}
PLANES = {"Z_uu_delta": number(-10.0, "kg/(m.rad)"), "M_uu_delta": number(-8.0, "kg/rad")}
ROLL = {"mass": {"I_xx": number(0.5, "kg.m2")}, "lift": {"K_up": number(-0.7, "kg.m")}}


@pytest.mark.parametrize(
    ("surface", "sections", "allowed"),
    [
        (RUDDER, ROLL, True),
        (PLANES | RUDDER, ROLL, True),
        (PLANES, {}, True),
        (PLANES, {"mass": ROLL["mass"]}, False),
        (PLANES, {"mass": ROLL["mass"], "damping": {"K_pp": number(-0.1, "kg.m2")}}, True),
        (PLANES, {"lift": ROLL["lift"]}, False),
        (PLANES, {"added_mass": {"Y_v_dot": number(-60.0, "kg")}}, False),
        ({"N_uu_delta": RUDDER["N_uu_delta"]}, ROLL, False),
        (PLANES | {"Y_uu_delta": RUDDER["Y_uu_delta"]}, ROLL, False),
        ({}, {}, False),
    ],
)
def test_what_a_vehicle_that_turns_needs(
    run_squid: Run, tmp_path: Path, surface: dict, sections: dict, allowed: bool
) -> None:
    vehicle = example("vehicle")
    # Keys that only Squid has are removed.
    for table, key in ((vehicle["mass"], "I_xx"), (vehicle["lift"], "K_up")):
        del table[key]
    for thruster in vehicle["thruster"]:
        thruster.pop("y", None)
    del vehicle["thruster_group"]
    ends = {"min": number(-10.0, "deg"), "max": number(10.0, "deg"), "lag": number(0.1, "s")}
    vehicle["control_surface"] = [{"name": "surface"} | surface | ends]
    for section, more in sections.items():
        vehicle[section] |= more
    assert bool(complaints(run_squid, tmp_path, "vehicle", vehicle)) != allowed
    assert Draft202012Validator(SCHEMAS["vehicle"]).is_valid(vehicle) == allowed


@pytest.mark.parametrize(
    ("delay", "allowed"), [(-0.5, False), (-1.0, False), (0.0, True), (10.0, True), (11.0, False)]
)
def test_the_limits_of_a_delay_are_those_at_the_longest_sample_time(
    run_squid: Run, tmp_path: Path, delay: float, allowed: bool
) -> None:
    """A shorter sample time has narrower limits, which a schema cannot express."""
    design = example("design")
    longest = SCHEMAS["design"]["properties"]["autopilot"]["properties"]["sample_time"]["maximum"]
    design["autopilot"] = {"sample_time": float(longest), "delay": delay}
    refused = "autopilot.delay" in keys_of(complaints(run_squid, tmp_path, "design", design))
    assert refused != allowed
    assert Draft202012Validator(SCHEMAS["design"]).is_valid(design) == allowed


def test_signs_and_units_of_a_vehicle_are_those_that_are_read(run_squid: Run, tmp_path: Path) -> None:
    """Every coefficient with a wrong sign, then with a wrong unit: schema and parser refuse all of them."""
    sections = SCHEMAS["vehicle"]["properties"]
    coefficients = [
        (section, key, schema["properties"])
        for section, table in sections.items()
        for key, schema in table.get("properties", {}).items()
        if schema.get("$ref") == "#/$defs/quantity"
        and section not in ("non_dimensional", "published_linear_model")
    ]
    wrong_signs, wrong_units, signed = example("vehicle"), example("vehicle"), []
    for section, key, schema in coefficients:
        unit = schema["unit"]["enum"][0]
        ends = [value for value, allowed in limits(schema.get("value", {})) if not allowed]
        signed += [key for _ in ends]
        value = (ends or [1.0])[0]
        wrong_signs.setdefault(section, {})[key] = {"value": value, "unit": unit, "source": "a test"}
        wrong_units.setdefault(section, {})[key] = {"value": 1.0, "unit": "furlong", "source": "a test"}
    assert len(signed) > 10
    validator = Draft202012Validator(SCHEMAS["vehicle"])
    for content, expected in ((wrong_signs, signed), (wrong_units, [key for _, key, _ in coefficients])):
        said = complaints(run_squid, tmp_path, "vehicle", copy.deepcopy(content))
        read = {key.split(".")[1] for key in keys_of(said) if "." in key}
        found = {
            error.absolute_path[1] for error in validator.iter_errors(content) if len(error.absolute_path) > 1
        }
        assert found == set(expected)
        assert set(expected) <= read


NPS = ROOT / "tests" / "vehicles" / "nps_auv_ii"


@pytest.mark.parametrize(
    ("change", "allowed"),
    [
        ({}, True),
        ({"surge": {"speed": "given"}}, True),
        ({"surge": {"speed": "held"}}, False),
        ({"surge": {}}, False),
        ({"drag": {"X_uu": {"value": -1.0, "unit": "kg/m", "source": "a test"}}}, False),
        ({"damping": {"X_u": {"value": -1.0, "unit": "kg/s", "source": "a test"}}}, False),
        ({"damping": {"Z_w": {"value": -1.0, "unit": "kg/s", "source": "a test"}}}, True),
        ({"surge": None}, False),
    ],
)
def test_a_given_speed_leaves_out_what_acts_on_it(
    run_squid: Run, tmp_path: Path, change: dict, allowed: bool
) -> None:
    """With a prescribed speed the added mass of surge must be absent."""
    content = tomllib.loads((NPS / "vehicle.toml").read_text(encoding="utf-8")) | change
    content = {key: value for key, value in content.items() if value is not None}
    vehicle = shutil.copytree(NPS, tmp_path / "nps")
    (vehicle / "vehicle.toml").write_text(written(content), encoding="utf-8")
    done = run_squid("show", vehicle, "--speed", "1.5")
    assert (done.returncode == 0) == allowed, done.stderr
    assert Draft202012Validator(SCHEMAS["vehicle"]).is_valid(content) == allowed
