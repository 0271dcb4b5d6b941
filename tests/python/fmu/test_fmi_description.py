"""Properties of the packaged model descriptions that validators do not check."""

from __future__ import annotations

import ctypes
import shutil
import zipfile
from collections import Counter
from pathlib import Path
from xml.etree import ElementTree

import fmpy
import pytest
from conftest import Run
from fly.package import Packages
from fly.stages import ROOT
from fmpy import extract, read_model_description
from fmpy.validation import validate_fmu
from lxml import etree

pytestmark = pytest.mark.change

KINDS = ("plant", "controller", "loop")
BASE_UNITS = {"kg", "m", "s", "A", "K", "mol", "cd", "rad"}
FUNCTIONS = """
    GetTypesPlatform GetVersion SetDebugLogging Instantiate FreeInstance SetupExperiment EnterInitializationMode
    ExitInitializationMode Terminate Reset GetReal GetInteger GetBoolean GetString SetReal SetInteger SetBoolean
    SetString GetFMUstate SetFMUstate FreeFMUstate SerializedFMUstateSize SerializeFMUstate DeSerializeFMUstate
    GetDirectionalDerivative EnterEventMode NewDiscreteStates EnterContinuousTimeMode CompletedIntegratorStep SetTime
    SetContinuousStates GetDerivatives GetEventIndicators GetContinuousStates GetNominalsOfContinuousStates
    SetRealInputDerivatives GetRealOutputDerivatives DoStep CancelStep GetStatus GetRealStatus GetIntegerStatus
    GetBooleanStatus GetStringStatus
"""


@pytest.fixture(params=KINDS)
def fmu(request: pytest.FixtureRequest, packages: Packages) -> Path:
    """Return each FMU of each vehicle."""
    return getattr(packages, request.param)


@pytest.fixture
def root(fmu: Path, tmp_path: Path) -> ElementTree.Element:
    """Return the root of the model description."""
    return ElementTree.parse(Path(extract(fmu, tmp_path)) / "modelDescription.xml").getroot()


def variables(root: ElementTree.Element) -> list[ElementTree.Element]:
    found = root.find("ModelVariables")
    assert found is not None
    return list(found)


def unknowns(root: ElementTree.Element, kind: str) -> list[ElementTree.Element]:
    """Return the entries of a list of ModelStructure; an empty list stands for none."""
    return root.findall(f"ModelStructure/{kind}/Unknown")


def test_fmpy_finds_nothing(fmu: Path) -> None:
    assert validate_fmu(fmu) == []


def test_names_and_references_are_unique(root: ElementTree.Element) -> None:
    for attribute in ("name", "valueReference"):
        counted = Counter(variable.get(attribute) for variable in variables(root))
        assert max(counted.values()) == 1


def test_values_lie_within_their_range(root: ElementTree.Element) -> None:
    checked = 0
    for variable in variables(root):
        for real in variable.findall("Real"):
            low, high = float(real.get("min", "-inf")), float(real.get("max", "inf"))
            assert low <= high, variable.get("name")
            if "start" in real.attrib:
                assert low <= float(real.attrib["start"]) <= high, variable.get("name")
                checked += 1
            assert float(real.get("nominal", "1")) > 0.0
    assert checked >= 4


def test_units_are_defined_in_base_units(root: ElementTree.Element) -> None:
    defined = {unit.attrib["name"]: unit for unit in root.findall("UnitDefinitions/Unit")}
    used = {real.attrib["unit"] for real in root.iter("Real")}
    assert set(defined) == used
    for unit in defined.values():
        bases = unit.findall("BaseUnit")
        assert len(bases) == 1 and set(bases[0].attrib) <= BASE_UNITS
    shown = {real.attrib["displayUnit"] for real in root.iter("Real") if "displayUnit" in real.attrib}
    assert shown <= {one.attrib["name"] for unit in defined.values() for one in unit.findall("DisplayUnit")}


def test_declared_types_agree_with_the_variables(root: ElementTree.Element) -> None:
    """A tool may take unit and limits from the type or from the variable (section 2.2.3): they agree."""
    types = {one.attrib["name"]: one[0] for one in root.findall("TypeDefinitions/SimpleType")}
    used, typed = set(), Counter()
    for variable in variables(root):
        declared = variable[0].get("declaredType")
        typed[variable[0].tag, declared is not None] += 1
        if declared is None:
            continue
        used.add(declared)
        simple = types[declared]
        assert simple.tag == variable[0].tag
        for attribute in ("unit", "displayUnit"):
            assert simple.get(attribute) == variable[0].get(attribute), variable.get("name")
        for attribute in ("min", "max"):
            assert simple.get(attribute) in (None, variable[0].get(attribute)), variable.get("name")
        assert simple.tag == "Enumeration" or simple.get("quantity")
    assert used == set(types)
    assert not used & {variable.get("name") for variable in variables(root)}, "section 2.2.3: names differ"
    assert typed["Enumeration", False] == 0
    assert typed["Real", True] > typed["Real", False], "coefficients alone have units without a name"


def test_every_start_value_is_where_the_standard_wants_it(root: ElementTree.Element) -> None:
    """Table in section 2.2.7: inputs and exact values have a start value, calculated ones do not."""
    allowed = {
        "parameter": {("fixed", "exact"), ("tunable", "exact")},
        "input": {("continuous", None), ("discrete", None)},
        "output": {("continuous", "calculated"), ("discrete", "calculated")},
        "local": {("continuous", "calculated"), ("constant", "exact")},
    }
    for variable in variables(root):
        causality, variability, initial = map(variable.get, ("causality", "variability", "initial"))
        assert (variability, initial) in allowed[causality], variable.get("name")
        assert ("start" in variable[0].attrib) == (causality == "input" or initial == "exact")
        assert variability != "continuous" or variable[0].tag == "Real"
        assert "reinit" not in variable[0].attrib, "states do not jump at events"


def test_indices_stand_in_order(root: ElementTree.Element) -> None:
    """Section 2.2.8: dependencies are ordered by index, and are present wherever their kinds are."""
    checked = 0
    for kind in ("Outputs", "Derivatives", "InitialUnknowns"):
        for unknown in unknowns(root, kind):
            on = [int(index) for index in unknown.get("dependencies", "").split()]
            assert on == sorted(on)
            assert ("dependencies" in unknown.attrib) == ("dependenciesKind" in unknown.attrib)
            checked += len(on)
    assert checked > 5


def test_structure_is_complete_and_without_repetition(root: ElementTree.Element) -> None:
    listed = variables(root)
    for kind in ("Outputs", "Derivatives", "InitialUnknowns"):
        indices = [int(unknown.attrib["index"]) for unknown in unknowns(root, kind)]
        assert len(indices) == len(set(indices))
        assert indices == sorted(indices)
    outputs = [i + 1 for i, variable in enumerate(listed) if variable.get("causality") == "output"]
    rates = [i + 1 for i, variable in enumerate(listed) if variable.find("Real[@derivative]") is not None]
    states = {int(listed[i - 1].find("Real").attrib["derivative"]) for i in rates}
    assert [int(unknown.attrib["index"]) for unknown in unknowns(root, "Outputs")] == outputs
    assert [int(unknown.attrib["index"]) for unknown in unknowns(root, "Derivatives")] == rates
    initial = {int(unknown.attrib["index"]) for unknown in unknowns(root, "InitialUnknowns")}
    assert initial == {*outputs, *rates, *states}
    assert len(states) == len(rates)


def test_dependencies_are_on_knowns(root: ElementTree.Element) -> None:
    listed = variables(root)
    states = {real.attrib["derivative"] for real in root.iter("Real") if "derivative" in real.attrib}
    inputs = {str(i + 1) for i, variable in enumerate(listed) if variable.get("causality") == "input"}
    exact = {str(i + 1) for i, variable in enumerate(listed) if variable.get("initial") == "exact"}
    for kind, knowns in (
        ("Outputs", inputs | states),
        ("Derivatives", inputs | states),
        ("InitialUnknowns", inputs | exact),
    ):
        for unknown in unknowns(root, kind):
            on, kinds = (unknown.get(name, "").split() for name in ("dependencies", "dependenciesKind"))
            assert set(on) <= knowns
            assert len(on) == len(set(on)) == len(kinds)
            assert set(kinds) <= {"dependent", "constant"}


def test_identity_is_told(fmu: Path, root: ElementTree.Element) -> None:
    for attribute in ("author", "version", "copyright", "license", "generationTool", "description"):
        assert root.get(attribute), attribute
    assert root.get("generationDateAndTime") is None, "the same files give the same bytes on any day"
    assert {category.get("name") for category in root.findall("LogCategories/Category")} == {
        "logStatusDiscard",
        "logStatusWarning",
        "logStatusError",
        "logStatusFatal",
    }
    interfaces = [one for one in root if one.tag in ("ModelExchange", "CoSimulation")]
    assert all(one.get("modelIdentifier") == fmu.stem for one in interfaces)
    for one in interfaces:
        for flag in ("canGetAndSetFMUstate", "canSerializeFMUstate", "providesDirectionalDerivative"):
            assert one.get(flag) == "true"


def test_interfaces_are_those_that_the_model_can_offer(packages: Packages) -> None:
    """A sampled controller has no continuous state to integrate and nothing to interpolate."""
    for kind, continuous in (("plant", True), ("controller", False), ("loop", True)):
        description = read_model_description(getattr(packages, kind))
        assert (description.modelExchange is not None) == continuous
        assert description.coSimulation.canInterpolateInputs == continuous
        assert description.coSimulation.maxOutputDerivativeOrder == int(continuous)
        assert description.coSimulation.canHandleVariableCommunicationStepSize


def test_every_function_is_exported(fmu: Path, tmp_path: Path) -> None:
    library = ctypes.CDLL(str(next((Path(extract(fmu, tmp_path)) / "binaries").rglob("*64/*.so"))))
    names = set(FUNCTIONS.split())
    assert len(names) == 44
    for name in names:
        assert hasattr(library, f"fmi2{name}"), name


def test_the_same_design_gives_the_same_bytes(run_squid: Run, squid: Packages, tmp_path: Path) -> None:
    again = tmp_path / "again"
    shutil.copytree(squid.plant.parent, again)
    vehicle = ROOT / "vehicles" / "squid"
    assert run_squid("package", vehicle, "--out", again).returncode == 0
    for kind in KINDS:
        first = getattr(squid, kind)
        assert (again / first.name).read_bytes() == first.read_bytes()


def plug(fmu: Path) -> ElementTree.Element:
    """Return the one terminal of an FMU."""
    with zipfile.ZipFile(fmu) as archive:
        text = archive.read("terminalsAndIcons/terminalsAndIcons.xml")
        assert archive.read("terminalsAndIcons/icon.png") == archive.read("model.png")
    schema = Path(fmpy.__file__).parent / "schema" / "fmi3" / "fmi3TerminalsAndIcons.xsd"
    etree.XMLSchema(etree.parse(str(schema))).assertValid(etree.fromstring(text))
    (found,) = ElementTree.fromstring(text).iter("Terminal")
    return found


def test_one_gesture_wires_plant_and_controller(packages: Packages) -> None:
    """The plugs name the same members, each an output on one side and an input of the same unit on the other."""
    ends = [plug(fmu) for fmu in (packages.plant, packages.controller)]
    members = [{one.get("memberName"): one.get("variableName") for one in end} for end in ends]
    assert list(members[0]) == list(members[1])
    assert len(members[0]) >= 3
    assert all(end.get("matchingRule") == "plug" for end in ends)
    sides = [
        {one.name: one for one in read_model_description(fmu).modelVariables}
        for fmu in (packages.plant, packages.controller)
    ]
    for name in members[0]:
        plant, controller = (side[member[name]] for side, member in zip(sides, members, strict=True))
        assert {plant.causality, controller.causality} == {"input", "output"}
        assert plant.unit == controller.unit
    with zipfile.ZipFile(packages.loop) as archive:
        assert "terminalsAndIcons/terminalsAndIcons.xml" not in archive.namelist()
