"""The system of plant and controller as SSP: valid by the schema, and simulated by tools that read it.

These tools step all components in parallel and exchange signals after the step, so that a command reaches the plant one
communication step after the tick that computed it. `squid.fmu`, and a master that steps the controller first, have no
such delay. The results differ in proportion to the communication step; the tests show both.
"""

from __future__ import annotations

import zipfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from flights import fly_alone, place, sample_time, turns
from fly.master import Signals, Slave, shared
from fly.package import Packages
from fly.record import differences
from fmpy import read_model_description
from fmpy.ssp.ssd import read_ssd, read_ssv, validate_tree
from importers import fly, of_pypi
from lxml import etree

pytestmark = pytest.mark.change

NAMES = {
    "oms": "https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd",
    "ssc": "http://ssp-standard.org/SSP1/SystemStructureCommon",
    "ssd": "http://ssp-standard.org/SSP1/SystemStructureDescription",
    "ssv": "http://ssp-standard.org/SSP1/SystemStructureParameterValues",
}
DURATION = 30.0
DEFAULT = 2
"""Which variant is the default: the third of six."""


@pytest.fixture
def packages(all_packages: Packages) -> Packages:
    """Return the FMUs of each vehicle in turn, in six degrees of freedom, too."""
    return all_packages


@pytest.fixture
def ssp(packages: Packages) -> Path:
    """Return the system of each vehicle in turn."""
    return packages.folder / f"{packages.vehicle}.ssp"


def structures(ssp: Path) -> dict[str, etree._Element]:
    """Return the system structure descriptions of an archive, by file."""
    with zipfile.ZipFile(ssp) as archive:
        files = [name for name in archive.namelist() if name.endswith(".ssd")]
        return {name: etree.fromstring(archive.read(name)) for name in files}


def variants(ssp: Path) -> list[str]:
    """Return the names of the variants, by speed."""
    return sorted(root.get("name") for root in structures(ssp).values())


def values(ssp: Path, component: str, variant: str) -> dict[str, float]:
    """Return the start values of a component in a variant."""
    found = read_ssv(str(ssp), f"resources/{component}_{variant}.ssv")
    return {parameter.name: float(parameter.value) for parameter in found.parameters}


def test_obeys_the_schema(ssp: Path) -> None:
    read_ssd(str(ssp))
    assert len(variants(ssp)) == 6
    with zipfile.ZipFile(ssp) as archive:
        for name in archive.namelist():
            if name.endswith(".ssd"):
                validate_tree(etree.fromstring(archive.read(name)), "SystemStructureDescription.xsd")
            elif name.endswith(".ssv"):
                validate_tree(etree.fromstring(archive.read(name)), "SystemStructureParameterValues.xsd")


def test_variants_have_names_of_their_own(ssp: Path) -> None:
    """SSP 1.0 selects variants by the name of the description; OMSimulator refuses two with one name."""
    named = {file: root.get("name") for file, root in structures(ssp).items()}
    assert len(set(named.values())) == len(named) == 6
    default = named.pop("SystemStructure.ssd")
    assert default == variants(ssp)[DEFAULT]
    assert named == {f"{name}.ssd": name for name in named.values()}


def test_tells_omsimulator_the_step(packages: Packages, ssp: Path) -> None:
    """One communication step per sample, at the location where OMSimulator reads it."""
    for root in structures(ssp).values():
        (annotation,) = root.iterfind("ssd:System/ssd:Annotations/ssc:Annotation", NAMES)
        assert annotation.get("type") == "org.openmodelica"
        (master,) = annotation.iterfind(
            "oms:Annotations/oms:SimulationInformation/oms:FixedStepMaster", NAMES
        )
        assert master.get("description") == "oms-ma"
        assert float(master.get("stepSize")) == sample_time(packages)


def test_the_schema_can_be_broken(ssp: Path) -> None:
    with zipfile.ZipFile(ssp) as archive:
        text = archive.read("SystemStructure.ssd").replace(b"startElement", b"startelement")
    with pytest.raises(Exception, match="startelement"):
        validate_tree(etree.fromstring(text), "SystemStructureDescription.xsd")


def test_names_what_it_holds(packages: Packages, ssp: Path) -> None:
    """Every source is in the archive, and the FMUs are those next to it, to the byte."""
    with zipfile.ZipFile(ssp) as archive:
        for root in structures(ssp).values():
            sources = {element.get("source") for element in root.iter() if element.get("source")}
            assert len(sources) == 4
            assert sources <= set(archive.namelist())
        for fmu in (packages.plant, packages.controller):
            assert archive.read(f"resources/{fmu.name}") == fmu.read_bytes()


def units_of(root: etree._Element) -> dict[str, dict[str, str]]:
    """Return the units that a file defines, with their powers of base units."""
    return {unit.get("name"): dict(unit[0].attrib) for unit in root.iterfind(".//ssc:Unit", NAMES)}


def test_every_number_has_a_unit(packages: Packages, ssp: Path) -> None:
    """Connectors and start values have the units of the FMUs, and each file defines exactly those that it uses."""
    descriptions = {"plant": packages.plant, "controller": packages.controller}
    variables = {
        component: {one.name: one for one in read_model_description(fmu).modelVariables}
        for component, fmu in descriptions.items()
    }
    with zipfile.ZipFile(ssp) as archive:
        for name in archive.namelist():
            if name.endswith(".fmu"):
                continue
            root = etree.fromstring(archive.read(name))
            used = set()
            if name.endswith(".ssv"):
                component = Path(name).name.split("_")[0]
                reals = [(component, real.getparent(), real) for real in root.iterfind(".//ssv:Real", NAMES)]
            else:
                reals = [
                    (real.getparent().getparent().getparent().get("name"), real.getparent(), real)
                    for real in root.iterfind(".//ssc:Real", NAMES)
                ]
            for component, owner, real in reals:
                assert real.get("unit") == variables[component][owner.get("name")].unit
                used.add(real.get("unit"))
            assert used
            assert set(units_of(root)) == used
    assert units_of(root).get("rad", {"rad": "1"}) == {"rad": "1"}


def test_wires_every_measurement_and_every_actuator(packages: Packages, ssp: Path) -> None:
    with Slave(packages.plant, "plant") as plant, Slave(packages.controller, "controller") as controller:
        for slave in (plant, controller):
            slave.begin()
            slave.ready()
        measured, commands = shared(plant, controller), shared(controller, plant)
    assert {"pitch", "speed", "pitch_rate"} <= set(measured)
    with zipfile.ZipFile(ssp) as archive:
        root = etree.fromstring(archive.read("SystemStructure.ssd"))
    wired = [
        tuple(element.get(end) for end in ("startElement", "startConnector", "endElement", "endConnector"))
        for element in root.iterfind(".//ssd:Connection", NAMES)
    ]
    expected = {("controller", name, "plant", name) for name in commands}
    expected |= {("plant", name, "controller", name) for name in measured}
    assert len(wired) == len(set(wired))
    assert set(wired) == expected


def test_parameter_sets_are_trims(packages: Packages, ssp: Path) -> None:
    """Each variant starts in the trim of its speed, with a step of pitch or depth above it as reference."""
    for variant in variants(ssp):
        at_plant, at_controller = values(ssp, "plant", variant), values(ssp, "controller", variant)
        assert f"speed_{at_plant['initial_speed']:.3f}" == variant
        if not turns(packages):
            assert at_plant["operating_speed"] == at_plant["initial_speed"]
        with Slave(packages.plant, "plant") as plant:
            plant.begin(at_plant)
            plant.ready()
            assert plant.get("pitch") == pytest.approx(at_controller["pitch"], abs=1e-9)
            assert plant.get("speed") == pytest.approx(at_controller["speed_reference"], abs=1e-9)
        tracked, least = ("depth", 0.5) if turns(packages) else ("pitch", 0.05)
        assert at_controller[f"{tracked}_reference"] - at_controller[tracked] > least


def in_one_fmu(packages: Packages, variant: str, ssp: Path) -> Signals:
    """Simulate a variant with the closed-loop FMU, which steps the controller first."""
    at_plant, at_controller = values(ssp, "plant", variant), values(ssp, "controller", variant)
    speed = at_plant["initial_speed"]
    wanted = {name: value for name, value in at_controller.items() if name.endswith("_reference")}
    return fly_alone(
        packages.loop,
        DURATION,
        sample_time(packages),
        {"speed_from": speed, "speed_to": speed},
        lambda _: {"manual": True, **wanted},
    )


def by_tool(
    importer: list[str | Path],
    ssp: Path,
    variant: str,
    step: float,
    folder: Path,
    recorded: Sequence[str] = ("pitch", "speed", "depth", "distance"),
) -> Signals:
    """Simulate the system with a tool that reads SSP; one row every 0.1 s."""
    plan = {
        "ssp": str(ssp),
        "instances": ["plant", "controller"],
        "parameter_set": variant,
        "step": step,
        "count": round(DURATION / step),
        "every": round(0.1 / step),
        "record": [f"plant.{name}" for name in recorded],
    }
    flown = fly(importer, plan, folder)
    return {name.removeprefix("plant."): signal for name, signal in flown.items()}


@pytest.fixture(params=["libcosim", "ecos"])
def tool(request: pytest.FixtureRequest) -> list[str | Path]:
    """Return the command of each tool that reads SSP in turn."""
    return of_pypi(request.param)


def test_flies_as_in_one_fmu(tool: list[str | Path], packages: Packages, ssp: Path, tmp_path: Path) -> None:
    """To 3e-3 at one communication step per sample, then in proportion to the step: only the delay differs."""
    variant = variants(ssp)[DEFAULT]
    tick = sample_time(packages)
    whole = in_one_fmu(packages, variant, ssp)
    rows = np.arange(1, round(DURATION / 0.1) + 1) * round(0.1 / tick)
    expected = {name: whole[name][rows] for name in ("pitch", "speed", *place(packages))}
    one, two, ten = (
        max(differences(expected, by_tool(tool, ssp, variant, tick / n, tmp_path, [*expected])).values())
        for n in (1, 2, 10)
    )
    print(f"{tool[-1]}: {one:.2e} at one communication step a sample, {two:.2e} at two, {ten:.2e} at ten")
    assert np.ptp(expected["pitch"]) > 0.05
    assert one < 3e-3
    assert two / ten == pytest.approx(10 / 2, rel=0.1)


def test_both_tools_agree(squid: Packages, tmp_path: Path) -> None:
    ssp = squid.folder / "squid.ssp"
    variant = variants(ssp)[DEFAULT]
    one, other = (by_tool(of_pypi(name), ssp, variant, 0.02, tmp_path) for name in ("libcosim", "ecos"))
    assert max(differences(one, other).values()) <= 1e-9
