"""Importers other than FMPy simulate the FMUs, each in its own process, with the results of FMPy.

All couple plant and controller in parallel, as most masters do: each FMU steps with the outputs of the others at the
last communication point, so that each command reaches the plant one communication step late. The result differs from
that of squid.fmu (`test_coupling.py` has a master that does not delay); here the importers must agree with one another.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path

import fmipp_importer
import fmpy
import numpy as np
import pytest
from flights import place, turns
from fly import libraries, record
from fly.master import Signals, Slave, shared
from fly.package import Packages
from fly.stages import ROOT
from importers import FOLDER, ImporterError, fly, of_pypi, others
from native import program

pytestmark = pytest.mark.change

AGREEMENT = 1e-9
NAMES = ["libcosim", "ecos", "container"]
COMPILED_HERE = ["fmi-crate", "fmu-runner", "fmi-rs", "fmipp"]
"""Importers that are compiled from their sources first, which takes minutes."""


@pytest.fixture(scope="session")
def fmi_crate() -> Path:
    """Return the importer of the crate `fmi`, whose bindings need libclang and the compiler's own headers."""
    compiler = program("gcc", "cc", "gcc", "clang")
    words = [others().python, "-c", "import clang; print(clang.__path__[0])"]
    clang = subprocess.run(
        words, env={**os.environ, **others().variables}, capture_output=True, text=True, check=True
    )
    headers = subprocess.run(
        [compiler, "-print-file-name=include"], capture_output=True, text=True, check=True
    )
    target = libraries.target_directory() / "importers"
    variables = {
        "LIBCLANG_PATH": str(Path(clang.stdout.strip()) / "native"),
        "BINDGEN_EXTRA_CLANG_ARGS": f"-I{headers.stdout.strip()}",
        "CARGO_TARGET_DIR": str(target),
    }
    folder = FOLDER / "fmi-crate"
    subprocess.run(
        ["cargo", "build", "--quiet", "--locked"], cwd=folder, env={**os.environ, **variables}, check=True
    )
    return target / "debug" / "fly-fmi"


@pytest.fixture(scope="session")
def other_crates() -> Path:
    """Return the folder with the importers of other crates, which need nothing but a C compiler."""
    target = libraries.target_directory() / "importers"
    subprocess.run(
        ["cargo", "build", "--quiet", "--locked"],
        cwd=FOLDER / "other-crates",
        env={**os.environ, "CARGO_TARGET_DIR": str(target)},
        check=True,
    )
    return target / "debug"


@pytest.fixture(scope="session")
def fmipp() -> list[str | Path]:
    """Return the command of the importer of the FMI++ Library."""
    return [*of_pypi("fmipp"), fmipp_importer.built()]


@pytest.fixture(params=[*NAMES, *(pytest.param(name, marks=pytest.mark.night) for name in COMPILED_HERE)])
def importer(request: pytest.FixtureRequest) -> list[str | Path]:
    """Return the command of each importer in turn; the plan follows as an argument."""
    if request.param == "fmi-crate":
        return [request.getfixturevalue("fmi_crate")]
    if request.param in ("fmu-runner", "fmi-rs"):
        return [request.getfixturevalue("other_crates") / f"fly-{request.param}"]
    if request.param == "fmipp":
        return request.getfixturevalue("fmipp")
    return of_pypi(request.param)


def by_fmpy(plan: Mapping) -> Signals:
    """Simulate a plan with FMPy."""
    rows = []
    with ExitStack() as stack:
        slaves = {name: stack.enter_context(Slave(Path(path), name)) for name, path in plan["fmus"].items()}

        def find(path: str) -> tuple[Slave, str]:
            name, variable = path.split(".", 1)
            return slaves[name], variable

        def get(path: str) -> float:
            slave, variable = find(path)
            return slave.get(variable)

        def exchange() -> None:
            values = [get(source) for source, _ in plan["connections"]]
            for (_, sink), value in zip(plan["connections"], values, strict=True):
                slave, variable = find(sink)
                slave.set(variable, value)

        for name, slave in slaves.items():
            own = {path.split(".", 1)[1]: v for path, v in plan["values"].items() if path.startswith(name)}
            slave.begin(own)
        for _ in slaves:  # A command at the start follows from a measurement at the start.
            exchange()
        for slave in slaves.values():
            slave.ready()
        for k in range(plan["count"]):
            for slave in slaves.values():
                slave.step_to((k + 1) * plan["step"])
            exchange()
            if (k + 1) % plan["every"] == 0:
                rows.append([(k + 1) * plan["step"], *map(get, plan["record"])])
    return dict(zip(["time", *plan["record"]], np.array(rows).T, strict=True))


@pytest.fixture
def packages(all_packages: Packages) -> Packages:
    """Return the FMUs of each vehicle in turn, in six degrees of freedom, too."""
    return all_packages


def loop_plan(packages: Packages) -> dict:
    """Return the plan for the closed-loop FMU with its own manoeuvre."""
    return {
        "fmus": {"loop": str(packages.loop)},
        "values": {},
        "connections": [],
        "step": 0.02,
        "count": 3000,
        "every": 10,
        "record": [f"loop.{name}" for name in ("pitch", "speed", *place(packages), "pitch_rate", "heave")],
    }


def coupled_plan(packages: Packages) -> dict:
    """Return the plan for plant and controller from trim to a constant pitch, or to a depth and a heading."""
    with Slave(packages.plant, "plant") as plant, Slave(packages.controller, "controller") as controller:
        measured, actuators = shared(plant, controller), shared(controller, plant)
        plant.begin({"initial_speed": 1.5})
        plant.ready()
        values = {
            "plant.initial_speed": 1.5,
            "controller.speed_reference": plant.get("speed"),
        }
        if turns(packages):
            values["controller.depth_reference"] = plant.get("depth") + 3.0
            values["controller.heading_reference"] = np.deg2rad(20.0)
        else:
            values["controller.pitch_reference"] = plant.get("trim_pitch") + np.deg2rad(10.0)
        controller.begin()
        controller.ready()
    return {
        "fmus": {"plant": str(packages.plant), "controller": str(packages.controller)},
        "values": values,
        "connections": [
            *((f"plant.{name}", f"controller.{name}") for name in measured),
            *((f"controller.{name}", f"plant.{name}") for name in actuators),
        ],
        "step": 0.02,
        "count": 2000,
        "every": 10,
        "record": [
            *(f"plant.{name}" for name in ("pitch", "speed", *place(packages))),
            *(f"controller.{name}" for name in actuators),
        ],
    }


PLANS = {"loop": loop_plan, "coupled": coupled_plan}


@pytest.mark.parametrize("which", PLANS)
def test_importers_agree(importer: list[str | Path], which: str, packages: Packages, tmp_path: Path) -> None:
    plan = PLANS[which](packages)
    expected = by_fmpy(plan)
    found = record.differences(expected, fly(importer, plan, tmp_path))
    assert set(found) == set(plan["record"])
    assert max(found.values()) <= AGREEMENT, found
    pitch = expected[plan["record"][0]]
    assert np.ptp(pitch) > 0.05, "it flies"


def test_an_importer_that_cannot_fly_is_seen(
    importer: list[str | Path], squid: Packages, tmp_path: Path
) -> None:
    broken = tmp_path / "broken.fmu"
    broken.write_bytes(squid.loop.read_bytes()[:1000])
    plan = {**loop_plan(squid), "fmus": {"loop": str(broken)}}
    with pytest.raises(ImporterError):
        fly(importer, plan, tmp_path)


def test_one_plug_stands_for_all_connections(packages: Packages, tmp_path: Path) -> None:
    """A tool that supports terminals connects plant and controller by one line."""
    plan = {**coupled_plan(packages), "plugs": [("plant.autopilot", "controller.vehicle")]}
    found = record.differences(by_fmpy(plan), fly(of_pypi("container"), plan, tmp_path))
    assert max(found.values()) <= AGREEMENT, found


def by_euler(importer: Path, packages: Packages, refined: int, folder: Path) -> float:
    """Return the difference between model exchange with Euler's method and co-simulation of the loop."""
    plan = {**loop_plan(packages), "step": 0.002 / refined, "count": 15_000 * refined, "every": 50 * refined}
    plan["out"] = str(folder / "exchange.csv")
    path = folder / "plan.json"
    path.write_text(json.dumps(plan), encoding="utf-8")
    subprocess.run([importer, path], check=True, timeout=120)
    found, expected = record.read(Path(plan["out"])), by_fmpy({**loop_plan(packages), "every": 5})
    # An event has one row before and one after it.
    last = [np.flatnonzero(np.abs(found["time"] - 0.1 * k) < 1e-9)[-1] for k in range(1, 300)]
    at_ends = {name: found[name][last] for name in plan["record"]}
    return max(record.differences({name: expected[name][:299] for name in plan["record"]}, at_ends).values())


@pytest.mark.night
def test_model_exchange_arrives_where_co_simulation_does(
    other_crates: Path, packages: Packages, tmp_path: Path
) -> None:
    """The ticks are time events; the difference is the error of Euler's method, proportional to its step."""
    coarse, fine = (by_euler(other_crates / "exchange-fmi-rs", packages, n, tmp_path) for n in (1, 4))
    assert coarse < 1e-3
    assert 3.5 < coarse / fine < 4.5


@pytest.mark.night
def test_model_exchange_with_step_control(
    fmipp: list[str | Path], packages: Packages, tmp_path: Path
) -> None:
    """FMI++ with the method of Dormand and Prince, which controls its steps and stops at each tick."""
    plan = loop_plan(packages)
    found = fly(fmipp, {**plan, "interface": "model exchange"}, tmp_path)
    apart = record.differences(by_fmpy(plan), found)
    assert set(apart) == set(plan["record"])
    assert max(apart.values()) <= 1e-8, apart


C_TYPES = {
    "Component": "fmi2Component",
    "FmuState": "fmi2FMUstate",
    "Status": "fmi2Status",
    "StatusKind": "fmi2StatusKind",
    "CallbackFunctions": "fmi2CallbackFunctions",
    "EventInfo": "fmi2EventInfo",
    "Type": "fmi2Type",
    "f64": "double",
    "u32": "unsigned int",
    "u8": "char",
    "usize": "size_t",
    "c_int": "int",
    "c_char": "char",
    "()": "void",
}


def c_type(rust: str) -> str:
    """Return the C type for a type of the export macro."""
    rust = rust.strip()
    if rust.startswith("*const "):
        return f"{c_type(rust[7:])} const *"
    return f"{c_type(rust[5:])} *" if rust.startswith("*mut ") else C_TYPES[rust]


def exported() -> dict[str, str]:
    """Return the C prototype of each function that the macro `fmi2::export!` exports."""
    sources = (ROOT / "crates" / "fmi2" / "src" / "abi").glob("*.rs")
    text = "\n".join(path.read_text(encoding="utf-8") for path in sorted(sources))
    rows = re.findall(r"(fmi2\w+) = \w+::\w+\s*\(([^)]*)\);", text)
    found = [(name, f"component: Component, {arguments}", "Status") for name, arguments in rows]
    apart = re.findall(r'extern "C" fn (fmi2\w+)\(([^)]*)\)(?: -> ([^{]+))? \{', text)
    found += [(name, arguments, result or "()") for name, arguments, result in apart]
    prototypes = {}
    for name, arguments, result in found:
        # An enumeration that Rust cannot represent, since an importer may send any value; it is passed as an int.
        arguments = arguments.replace("fmu_type: c_int", "fmu_type: Type")
        types = [c_type(argument.split(":", 1)[1]) for argument in arguments.split(",") if argument.strip()]
        prototypes[name] = f"{c_type(result)} {name}({', '.join(types) or 'void'});"
    return prototypes


def declared(headers: Path) -> set[str]:
    """Return the functions that the header of the standard declares."""
    text = (headers / "fmi2Functions.h").read_text(encoding="utf-8", errors="replace")
    return set(re.findall(r"FMI2_Export\s+fmi2\w+TYPE\s+(fmi2\w+);", text))


def compiles(source: str, headers: Path, folder: Path) -> subprocess.CompletedProcess:
    path = folder / "prototypes.c"
    path.write_text(source, encoding="utf-8")
    words = [program("gcc", "cc", "gcc", "clang"), "-std=c11", "-fsyntax-only", f"-I{headers}", path]
    return subprocess.run(words, capture_output=True, text=True, check=False)


def test_exported_functions_have_the_types_of_the_standard(tmp_path: Path) -> None:
    """A prototype that conflicts with the header of FMI 2.0 does not compile."""
    headers = Path(fmpy.__file__).parent / "c-code"
    prototypes = exported()
    assert set(prototypes) <= declared(headers)
    assert {"fmi2Instantiate", "fmi2DoStep", "fmi2SerializeFMUstate"} <= set(prototypes)
    source = "\n".join(['#include "fmi2Functions.h"', *prototypes.values(), ""])
    done = compiles(source, headers, tmp_path)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("name", ["fmi2DoStep", "fmi2GetString", "fmi2Instantiate", "fmi2FreeInstance"])
def test_a_wrong_type_would_be_seen(tmp_path: Path, name: str) -> None:
    headers = Path(fmpy.__file__).parent / "c-code"
    wrong = exported()[name].replace(");", ", double);")
    assert compiles(f'#include "fmi2Functions.h"\n{wrong}\n', headers, tmp_path).returncode != 0
