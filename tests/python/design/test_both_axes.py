"""The autopilots of depth and heading of REMUS 100 in one FMU: packed, simulated and verified."""

from __future__ import annotations

import ctypes
import json
import re
import shutil
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from claims import claim
from conftest import (
    FAILED,
    REMUS100,
    Run,
    heading_alone,
    kept,
    masked,
    messages,
    mistakes,
    named,
    refusal,
    rewritten,
)
from embedded import STRICT, call, gcc
from fly.master import Slave
from fmpy import read_model_description
from fmpy.validation import validate_fmu
from syrupy.assertion import SnapshotAssertion

pytestmark = pytest.mark.change

NAME = "remus100_controller.fmu"


@dataclass(frozen=True)
class Made:
    """FMUs of the controllers: of each axis, and of both."""

    depth: Path
    heading: Path
    both: Path
    build: Path
    """`build`, in which `squid` finds the design from its parent."""
    answer: dict
    """What `squid package --json` says of both."""

    def copy(self, folder: Path) -> Path:
        """Copy the designs for a test that modifies them; return the directory in which to run `squid`."""
        shutil.copytree(self.build, folder / "build", ignore=shutil.ignore_patterns("*.fmu"))
        return folder


@pytest.fixture(scope="session")
def made(run_squid: Run, tmp_path_factory: pytest.TempPathFactory) -> Made:
    """Package both axes in a folder with a copy of both designs."""
    alone = {
        "depth": kept(run_squid, REMUS100, "--axis", "depth").folder,
        "heading": heading_alone(run_squid),
    }
    here = tmp_path_factory.mktemp("both")
    for name, folder in alone.items():
        ignored = shutil.ignore_patterns("*.fmu", "*.ssp", "*.txt")
        shutil.copytree(folder, here / "build" / "remus100" / "design" / name, ignore=ignored)
    done = run_squid("package", REMUS100, "--json", cwd=here)
    assert done.returncode == 0, done.stderr
    depth, heading = (folder / NAME for folder in alone.values())
    both = here / "build" / "remus100" / "design" / NAME
    return Made(depth, heading, both, here / "build", json.loads(done.stdout))


def turns_of(text: str) -> tuple[str, str]:
    """Return the rates of turn (deg/s) up to which both axes are said to be proved together, for the range of speed."""
    return re.findall(r"([\d.]+) to ([\d.]+) deg/s", text.replace("\u00a0", " "))[0]


def counted(text: str) -> str:
    """Return a text for a snapshot, without the number of turns that were computed."""
    return re.sub(r"\d+ turns", "# turns", masked(text))


def test_both_are_packed(run_squid: Run, made: Made, tmp_path: Path, snapshot: SnapshotAssertion) -> None:
    files = ["remus100.fmu", "remus100.ssp", NAME, "remus100_plant.fmu"]
    assert sorted(made.answer["files"]) == [str(Path("build", "remus100", "design", name)) for name in files]
    for lines in (made.answer["claims"], made.answer["proof"].splitlines()):
        axes = [line.split(": ")[0] for line in lines]
        assert set(axes) == {"depth", "heading"} and axes == sorted(axes), lines
        assert all(": certified: " in line for line in lines)
    with zipfile.ZipFile(made.both) as fmu:
        for index, axis in (("", "depth"), ("_2", "heading")):
            for name in ("controller", "certificate"):
                stored = made.build / "remus100" / "design" / axis / f"{name}.json"
                assert fmu.read(f"resources/{name}{index}.json") == stored.read_bytes()
            coupling = json.loads(fmu.read(f"resources/coupling_certificate{index}.json"))
            assert coupling["controller"] == json.loads(stored.read_bytes())["controller"]
        page = fmu.read("documentation/index.html").decode()
    about = re.findall(r"<p>(.*?)</p>", page.partition("<nav>")[0])
    assert counted("\n".join(about)) == snapshot
    assert turns_of(made.answer["coupling"]) == turns_of(page) == ("10.22", "12")
    done = run_squid("package", REMUS100, "--descriptions", tmp_path, cwd=made.build.parent)
    assert done.returncode == 0, done.stderr
    with zipfile.ZipFile(made.both) as fmu:
        described = tmp_path / NAME.replace(".fmu", ".xml")
        assert described.read_bytes() == fmu.read("modelDescription.xml")


def test_it_is_legal_and_commands_as_each_does_alone(made: Made) -> None:
    """Each axis commands the same bits as alone, whatever the other measures."""
    assert validate_fmu(str(made.both)) == []
    names = {
        path: {v.name for v in read_model_description(path).modelVariables if v.causality == "input"}
        for path in (made.depth, made.heading, made.both)
    }
    assert names[made.both] == names[made.depth] | names[made.heading]
    random = np.random.default_rng(5)
    level = {"depth": 20.0, "depth_reference": 20.0, "speed": 1.8, "speed_reference": 1.8}
    moved = (
        "pitch",
        "pitch_rate",
        "depth",
        "depth_reference",
        "heading",
        "heading_rate",
        "heading_reference",
    )
    largest: dict[str, float] = {}
    with (
        Slave(made.both, "both") as both,
        Slave(made.depth, "depth") as depth,
        Slave(made.heading, "heading") as heading,
    ):
        for slave in (both, depth, heading):
            slave.begin({name: value for name, value in level.items() if name in slave.variables})
            slave.ready()
        for tick in range(1, 501):
            values = {name: level.get(name, 0.0) + 0.02 * random.normal() for name in moved}
            values["speed"] = 1.8 + 0.3 * np.sin(0.01 * tick)
            for slave in (both, depth, heading):
                for name in values.keys() & slave.variables.keys():
                    slave.set(name, values[name])
                slave.step_to(0.02 * tick)
            for slave, commands in ((depth, ("stern_planes", "propeller")), (heading, ("rudder",))):
                for name in commands:
                    assert both.get(name) == slave.get(name), (tick, name)
                    largest[name] = max(largest.get(name, 0.0), abs(slave.get(name)))
    assert all(value > 0.0 for value in largest.values()), largest


class Source:
    """The exported autopilot of all axes, compiled."""

    def __init__(self, folder: Path, name: str) -> None:
        library = folder / "all.so"
        sources = [folder / f"{name}.c", *sorted(folder.glob("*/*.c"))]
        call(*gcc(), "-O2", *STRICT, "-shared", "-fPIC", f"-I{folder}", "-o", library, *sources)
        header = (folder / f"{name}.h").read_text(encoding="utf-8")
        self.library, self.name = ctypes.CDLL(str(library)), name
        self.inputs, self.outputs = (self.struct(header, of)() for of in ("inputs", "outputs"))
        self.state = (ctypes.c_double * 4096)()

    def struct(self, header: str, of: str) -> type[ctypes.Structure]:
        """Return the type of a struct in the header."""
        text = header.split(f"}} {self.name}_{of};")[0].rsplit("typedef struct {", 1)[1]
        kinds = {f"{self.name}_real": ctypes.c_double, "unsigned": ctypes.c_uint}
        fields = [(name, kinds[kind]) for kind, name in re.findall(r"^    (\w+) (\w+);", text, re.MULTILINE)]
        return type(of, (ctypes.Structure,), {"_fields_": fields})

    def call(self, name: str) -> int:
        """Call `reset` or `step`; return its result."""
        arguments = [ctypes.byref(one) for one in (self.state, self.inputs, self.outputs)]
        return getattr(self.library, f"{self.name}_{name}")(*arguments)


def test_its_source_is_one_autopilot(run_squid: Run, made: Made, tmp_path: Path) -> None:
    """The source commands the same bits as the FMU; an axis that refuses its reference does not stop the other."""
    done = run_squid("export", REMUS100, "--to", tmp_path, cwd=made.build.parent)
    assert done.returncode == 0, done.stderr
    source = Source(tmp_path, "remus100")
    level = {"depth": 20.0, "depth_reference": 20.0, "speed": 1.8, "speed_reference": 1.8}
    random = np.random.default_rng(7)
    moved = (
        "pitch",
        "pitch_rate",
        "depth",
        "depth_reference",
        "heading",
        "heading_rate",
        "heading_reference",
    )
    given = [name for name, kind in source.outputs._fields_ if kind is ctypes.c_double]
    with Slave(made.both, "both") as both:
        both.begin(level)
        both.ready()
        for name, _ in source.inputs._fields_:
            setattr(source.inputs, name, both.get(name) if name in both.variables else 0.0)
        for tick in range(1, 301):
            values = {name: level.get(name, 0.0) + 0.02 * random.normal() for name in moved}
            values["speed"] = 1.8 + 0.3 * np.sin(0.01 * tick)
            for name, value in values.items():
                setattr(source.inputs, name, value)
                both.set(name, value)
            # The FMU initialises from the inputs of its first tick.
            assert tick > 1 or source.call("reset") == 0
            assert source.call("step") == 0
            both.step_to(0.02 * tick)
            for name in given:
                assert getattr(source.outputs, name) == both.get(name), (tick, name)
    before = source.outputs.rudder, source.outputs.stern_planes
    source.inputs.heading_reference = float("nan")
    source.inputs.pitch = 0.2
    assert source.call("step") == 1
    assert source.outputs.rudder == before[0] and source.outputs.stern_planes != before[1]
    before = bytes(source.state), bytes(source.outputs)
    assert source.call("reset") == 1 and (bytes(source.state), bytes(source.outputs)) == before


def test_both_are_proved_again(run_squid: Run, made: Made, snapshot: SnapshotAssertion) -> None:
    done = run_squid("verify", made.both, "--json")
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    each = [json.loads(run_squid("verify", fmu, "--json").stdout) for fmu in (made.depth, made.heading)]
    assert all("axes" not in one for one in each)
    assert all(one.pop("warnings") == [] for one in (found, *each))
    assert found.pop("coupling") is None, "nothing is claimed of both without the vehicle's files"
    for one in (found, *each):
        assert one.pop("not_examined") and "model.png" in one.pop("identical")
    assert found.pop("axes") == [
        {**one, "axis": name} for one, name in zip(each, ("depth", "heading"), strict=True)
    ]
    assert found == each[0]
    done = run_squid("verify", made.both, "--vehicle", REMUS100, "--json")
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert turns_of(found["coupling"]) == ("10.22", "12")
    said = [found["coupling"]]
    for axis in found["axes"]:
        assert axis["status"] == "proved" and all(f"'{axis['axis']}'" in about for about in axis["about"])
        said += axis["about"]
    assert counted(named("\n".join(said))) == snapshot
    lines = run_squid("verify", made.both, "--vehicle", REMUS100).stdout.splitlines()
    starts = {line.split(":")[0] for line in lines if ": " in line}
    assert starts >= {"depth", "heading", "PROVED"}


def frozen(certificate: dict, theta: dict[int, float]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Close the loop of a certificate at constant parameters: A, B and C, from d to e."""
    plant = {name: np.array(rows, dtype=float) for name, rows in certificate["plant"].items()}
    law = {name: np.array(rows, dtype=float) for name, rows in certificate["controller"].items()}

    def at(blocks: list[int], inner: np.ndarray) -> np.ndarray:
        delta = np.diag([theta[i] for i, count in enumerate(blocks) for _ in range(count)])
        return delta @ np.linalg.inv(np.eye(len(delta)) - inner @ delta)

    p, k = (
        at(certificate["blocks"], plant["Dtt"]),
        at(certificate["controller_blocks"], law["Dtt"]),
    )
    a, b1 = plant["A"] + plant["Bt"] @ p @ plant["Ct"], plant["B1"]
    c1 = plant["C1"]
    c2 = plant["C2"] + plant["D2t"] @ p @ plant["Ct"]
    b2 = plant["B2"] + plant["Bt"] @ p @ plant["Dt2"]
    by, cu = law["By"] + law["Bt"] @ k @ law["Dty"], law["Cu"] + law["Dut"] @ k @ law["Ct"]
    ak, du = law["A"] + law["Bt"] @ k @ law["Ct"], law["Duy"] + law["Dut"] @ k @ law["Dty"]
    assert not plant["D12"].any()
    return (
        np.block([[a + b2 @ du @ c2, b2 @ cu], [by @ c2, ak]]),
        np.vstack([b1 + b2 @ du @ plant["D21"], by @ plant["D21"]]),
        np.hstack([c1, np.zeros((len(c1), len(ak)))]),
    )


def test_both_are_stable_under_whatever_the_coupling_may_be(made: Made) -> None:
    """An independent check: any d no longer than e keeps both loops stable, at constant speeds and in turns."""
    with zipfile.ZipFile(made.both) as fmu:
        both = [json.loads(fmu.read(f"resources/coupling_certificate{index}.json")) for index in ("", "_2")]
    gains = [claim(one, "gain")["gamma"] for one in both]
    assert max(gains) < 1.0 and np.prod(gains) < 0.9
    random = np.random.default_rng(7)
    for _ in range(40):
        theta = dict(enumerate(random.choice([-1.0, 1.0, 0.3], size=2)))
        (a1, b1, c1), (a2, b2, c2) = (frozen(one, theta) for one in both)
        for (a, b, c), gain in zip(((a1, b1, c1), (a2, b2, c2)), gains, strict=True):
            identity = np.eye(len(a))
            sizes = [
                np.linalg.norm(c @ np.linalg.solve(1j * w * identity - a, b), 2)
                for w in np.logspace(-3, 2, 60)
            ]
            assert np.linalg.eigvals(a).real.max() < 0.0 and max(sizes) < gain
        apart = np.zeros((len(a1), len(a2)))
        a = np.block([[a1, apart], [apart.T, a2]])
        b = np.block([[b1, np.zeros((len(a1), b2.shape[1]))], [np.zeros((len(a2), b1.shape[1])), b2]])
        c = np.block([[c1, np.zeros((len(c1), len(a2)))], [np.zeros((len(c2), len(a1))), c2]])
        coupling = random.normal(size=(b.shape[1], len(c)))
        coupling /= np.linalg.norm(coupling, 2)
        assert np.linalg.eigvals(a + b @ coupling @ c).real.max() < 0.0


TOGETHER = """
#include "remus100_depth.h"
#include "remus100_heading.h"
#include <stdio.h>

int main(void)
{
    remus100_depth_state depth;
    remus100_heading_state heading;
    remus100_depth_inputs level = {.depth = 20.0, .depth_reference = 20.0, .speed = 1.8, .speed_reference = 1.8};
    remus100_heading_inputs course = {.heading_reference = 0.1, .speed = 1.8};
    remus100_depth_outputs planes;
    remus100_heading_outputs rudder;
    remus100_depth_init(&depth, &planes);
    remus100_heading_init(&heading, &rudder);
    if (remus100_depth_reset(&depth, &level, &planes) != REMUS100_DEPTH_OK) return 1;
    if (remus100_heading_reset(&heading, &course, &rudder) != REMUS100_HEADING_OK) return 2;
    level.depth += 0.01, level.pitch += 1e-4, level.pitch_rate += 1e-4, level.speed += 1e-3;
    course.heading += 1e-4, course.heading_rate += 1e-4, course.speed += 1e-3;
    if (remus100_depth_step(&depth, &level, &planes) != REMUS100_DEPTH_OK) return 3;
    if (remus100_heading_step(&heading, &course, &rudder) != REMUS100_HEADING_OK) return 4;
    printf("%.17g %.17g", planes.stern_planes, rudder.rudder);
    return 0;
}
"""


def test_the_c_of_both_is_linked_together(run_squid: Run, made: Made, tmp_path: Path) -> None:
    main = tmp_path / "main.c"
    main.write_text(TOGETHER, encoding="utf-8")
    words: list[str | Path] = [main]
    done = run_squid("export", REMUS100, "--to", tmp_path, cwd=made.build.parent)
    assert done.returncode == 0, done.stderr
    for axis in ("depth", "heading"):
        words += [tmp_path / axis / f"remus100_{axis}.c", f"-I{tmp_path / axis}"]
    call("cc", "-std=c99", "-Wall", "-Wextra", "-Werror", *words, "-lm", "-o", tmp_path / "both")
    planes, rudder = (float(word) for word in call(tmp_path / "both").split())
    assert planes != 0.0 and rudder != 0.0


def amplify(content: bytes) -> bytes:
    """Change the control law: another digit of one of its numbers."""
    controller = json.loads(content)
    controller["lft"]["A"][0][0] *= 1 + 1e-15
    return json.dumps(controller).encode()


def rescale(content: bytes) -> bytes:
    """Change a value that is not in the certificate: the scale of a measurement."""
    controller = json.loads(content)
    controller["controller_inputs"][0]["scale"] /= 50
    return json.dumps(controller).encode()


@pytest.mark.parametrize(
    ("name", "change", "key"),
    [
        ("controller_2.json", amplify, "mismatch"),
        ("controller_2.json", rescale, "wrong_guid"),
        ("controller_2.json", lambda content: content.replace(b"heading", b"headinx", 1), "wrong_guid"),
        ("controller_2.json", lambda _: None, "wrong_guid"),
        ("certificate_2.json", lambda _: None, "no_certificate"),
        ("certificate_2.json", lambda content: content.replace(b"1", b"2", 1), "certificate"),
        ("coupling_certificate_2.json", lambda _: None, "wrong_guid"),
    ],
    ids=["law", "scale", "name", "no law", "no certificate", "certificate", "no coupling"],
)
def test_what_was_changed_is_refused(
    run_squid: Run,
    made: Made,
    tmp_path: Path,
    name: str,
    change: Callable[[bytes], bytes | None],
    key: str,
    snapshot: SnapshotAssertion,
) -> None:
    spoilt = rewritten(made.both, tmp_path / "spoilt.fmu", f"resources/{name}", change)
    done = run_squid("verify", spoilt, "--json")
    refusal(done, key)
    assert messages(done, TMP=tmp_path) == snapshot


def test_a_third_axis_without_a_controller_is_refused(run_squid: Run, made: Made, tmp_path: Path) -> None:
    spoilt = tmp_path / "spoilt.fmu"
    shutil.copy(made.both, spoilt)
    with zipfile.ZipFile(spoilt, "a") as fmu:
        fmu.writestr("resources/controller_3.json", "{}")
    assert str(spoilt) in refusal(run_squid("verify", spoilt, "--json"), "controller_design")["reason"]


def test_an_axis_without_proof_is_packed_only_if_asked(
    run_squid: Run, made: Made, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    here = made.copy(tmp_path)
    (here / "build" / "remus100" / "design" / "heading" / "certificate.json").unlink()
    done = run_squid("package", REMUS100, "--json", cwd=here)
    refusal(done, "uncertified")
    assert messages(done) == snapshot
    fmu = here / "build" / "remus100" / "design" / NAME
    assert not fmu.exists()
    done = run_squid("package", REMUS100, "--allow-uncertified", cwd=here)
    assert done.returncode == 0, done.stderr
    assert "depth: certified: " in done.stdout and "heading: UNCERTIFIED: " in done.stdout
    assert {v.name: v.start for v in read_model_description(fmu).modelVariables if "certified" in v.name} == {
        "gamma_certified": "true",
        "heading_gamma_certified": "false",
    }
    refusal(run_squid("verify", fmu, "--json"), "no_certificate")


@pytest.mark.parametrize(
    ("words", "key", "code"),
    [(["--axis", "pitch"], "no_axis", 1), (["--axis", "heading", "--kind", "me"], "argument", 64)],
)
def test_what_cannot_be_packed_says_why(
    run_squid: Run, tmp_path: Path, words: list[str], key: str, code: int, snapshot: SnapshotAssertion
) -> None:
    done = run_squid("package", REMUS100, *words, "--json", cwd=tmp_path)
    refusal(done, key, code)
    assert messages(done) == snapshot
    assert not list(tmp_path.iterdir())


def changed(tmp_path: Path, shared: dict[str, str], *of_axes: dict[str, str]) -> Path:
    """Return a copy of the vehicle with parts of its design replaced, in the shared part and in each axis."""
    vehicle = Path(shutil.copytree(REMUS100, tmp_path / "vehicle"))
    design = vehicle / "design.toml"
    parts = design.read_text(encoding="utf-8").split("[[axis]]\n")
    for place, changes in enumerate((shared, *of_axes)):
        for old, new in changes.items():
            assert parts[place].count(old) == 1, old
            parts[place] = parts[place].replace(old, new)
    design.write_text("[[axis]]\n".join(parts), encoding="utf-8")
    return vehicle


CONTROL = "[axis.control]\n"
STEP = "[axis.manoeuvre]\n"
CLOCK = "[autopilot]\nsample_time = 0.02\n"
SPEEDS = "speed_min = 1.4\nspeed_max = 2.2\n"
RAMP = "speed_from = 1.5\nspeed_to = 2.1\n"


@pytest.mark.parametrize(
    ("shared", "depth", "heading", "key"),
    [
        (
            {CLOCK: ""},
            {CONTROL: f"[axis.autopilot]\nsample_time = 0.02\n{CONTROL}"},
            {CONTROL: f"[axis.autopilot]\nsample_time = 0.04\n{CONTROL}"},
            "axes_differ",
        ),
        (
            {"depth = 20.0\n": ""},
            {CONTROL: f"[axis.model]\ndepth = 20.0\n{CONTROL}"},
            {CONTROL: f"[axis.model]\ndepth = 25.0\n{CONTROL}"},
            "axes_differ",
        ),
        (
            {SPEEDS: "", RAMP: ""},
            {CONTROL: f"[axis.model]\n{SPEEDS}{CONTROL}", STEP: STEP + RAMP},
            {
                CONTROL: f"[axis.model]\nspeed_min = 2.3\nspeed_max = 2.5\n{CONTROL}",
                STEP: f"{STEP}speed_from = 2.3\nspeed_to = 2.4\n",
            },
            "no_common_speed",
        ),
        (
            {},
            {CONTROL: f"[axis.autopilot]\nsample_time = 0.02\n{CONTROL}"},
            {},
            "autopilot.sample_time",
        ),
        ({"Z_ww = 0.3": "Z_wv = 0.3"}, {}, {}, "unknown_coefficient"),
        ({}, {}, {CONTROL: "[axis.contrl]\n"}, "contrl"),
        ({"sample_time = 0.02": "sample_tme = 0.02"}, {}, {}, "autopilot.sample_tme"),
    ],
)
def test_axes_of_one_vehicle(
    run_squid: Run,
    tmp_path: Path,
    shared: dict[str, str],
    depth: dict[str, str],
    heading: dict[str, str],
    key: str,
    snapshot: SnapshotAssertion,
) -> None:
    """Axes share sample time, depth and speed; each key has one place, and is reported once."""
    done = run_squid("design", changed(tmp_path, shared, depth, heading), "--json", cwd=tmp_path)
    answer = json.loads(done.stdout)
    found = [mistake.get("key", mistake["problem"]) for mistake in answer.get("mistakes", [])]
    assert done.returncode == 1 and (found or [answer["key"]]) == [key], answer
    assert messages(done, TMP=tmp_path) == snapshot
    assert not (tmp_path / "build").exists()


def test_the_order_of_axes_does_not_matter(run_squid: Run, tmp_path: Path) -> None:
    """The axis of level flight is first; names of axes, folders and certificates do not depend on the file's order."""
    vehicle = changed(tmp_path, {})
    show = ("show", vehicle, "--speed", "1.8", "--json")
    before = run_squid(*show, cwd=tmp_path)
    design = vehicle / "design.toml"
    shared, depth, heading = design.read_text(encoding="utf-8").split("[[axis]]\n")
    design.write_text("[[axis]]\n".join((shared, heading, f"\n{depth}")), encoding="utf-8")
    after = run_squid(*show, cwd=tmp_path)
    assert [axis["axis"] for axis in json.loads(after.stdout)["axes"]] == ["depth", "heading"]
    assert after.stdout == before.stdout


def test_what_was_packed_of_another_design_goes(
    run_squid: Run, made: Made, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """A redesigned axis invalidates the FMUs of all axes and the certificates of both."""
    vehicle, here = (
        changed(tmp_path / "other", {}, {}, {"back_off = 0.04": "back_off = 0.05"}),
        made.copy(tmp_path),
    )
    folder = here / "build" / "remus100" / "design"
    shutil.move(vehicle, here / "remus100")
    shutil.copy(made.both, folder)
    for mark in folder.glob("*/.squid-vehicle"):
        mark.unlink()
    done = run_squid("design", here / "remus100", "--axis", "heading", "--no-advise", cwd=here)
    assert done.returncode == 0, done.stderr
    (removed,) = (line for line in done.stdout.splitlines() if NAME in line)
    assert not (folder / NAME).exists()
    done = run_squid("package", here / "remus100", "--json", cwd=here)
    refusal(done, "stale")
    assert f"{removed}\n{messages(done)}" == snapshot


def test_two_axes_do_not_steer_the_same(run_squid: Run, tmp_path: Path) -> None:
    vehicle = changed(tmp_path, {})
    design = vehicle / "design.toml"
    shared, _, heading = design.read_text(encoding="utf-8").split("[[axis]]\n")
    design.write_text("[[axis]]\n".join((shared, heading, heading)), encoding="utf-8")
    ((_, key),) = mistakes(run_squid("design", vehicle, "--json", cwd=tmp_path))
    assert key == "axis"


def test_verify_wants_the_axes_that_are_there(
    run_squid: Run, made: Made, snapshot: SnapshotAssertion
) -> None:
    certificate = made.build / "remus100" / "design" / "depth" / "certificate.json"
    whole = ("--vehicle", REMUS100)
    said = []
    for words, key, code in [
        ((made.both, *whole, "--axis", "depth"), "other_axes", 1),
        ((made.depth, *whole), "other_axes", 1),
        ((certificate, *whole), "other_axes", 1),
        ((made.both, *whole, "--design", "pitch"), "other_axes", 1),
        ((made.both, "--axis", "heading"), "usage", 64),
    ]:
        done = run_squid("verify", *words, "--json")
        refusal(done, key, code)
        said.append(messages(done, BOTH=made.both.parent, DEPTH=made.depth.parent))
    assert "\n".join(said) == snapshot
    done = run_squid("verify", certificate, *whole, "--axis", "depth")
    assert done.returncode == 0, done.stderr


GAINS = ("gain of stern_planes", "gain of rudder")
"""Uncertain parameters."""


def test_a_campaign_flies_both(
    run_squid: Run, made: Made, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """The uncertainty of both axes is sampled for each flight, which is in six degrees of freedom."""
    here = made.copy(tmp_path)
    done = run_squid("campaign", REMUS100, "--flights", "8", "--json", cwd=here, timeout=900.0)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    names = [one["figure"] for one in found["figures"]]
    assert {"depth_overshoot", "depth_error_rms", "heading_overshoot", "heading_error_rms"} <= set(names)
    assert names.count("speed_error_rms") == 1 and not {"overshoot", "heading_speed_error_rms"} & set(names)
    pushed = {name for one in found["figures"] for name, _ in one["pushed_by"]}
    assert {"Z_uq", "N_uv", "rudder.N_uu_delta", *GAINS} <= pushed
    assert {"depth_step", "heading_step"} <= pushed
    assert {one["axis"] for one in found["gains"]} == {"depth", "heading"}
    for one in found["gains"]:
        assert one["largest"] < one["guaranteed"], one
    assert next(one for one in found["outcomes"] if one["outcome"] == "flown")["flights"] == 8
    results = here / found["directory"]
    done = run_squid("replay", results, "--flight", "3", "--json", cwd=here)
    assert done.returncode == 0 and json.loads(done.stdout)["same"], done.stderr
    columns = (results / "flight-3.csv").read_text(encoding="utf-8").splitlines()[0].split(",")
    assert {"heading [rad]", "roll [rad]", "east [m]", "rudder [rad]", "propeller [N]"} <= set(columns)
    words = ["--flights", "8", "--records", tmp_path, "--to", tmp_path / "by", "--json"]
    done = run_squid("campaign", REMUS100, *words, cwd=here)
    refusal(done, "not_of_fmus")
    assert messages(done) == snapshot


def test_the_report_has_both_on_one_page(
    run_squid: Run, made: Made, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """Each section belongs to an axis, except that on turns, which belongs to both; all anchors differ."""
    here = made.copy(tmp_path)
    done = run_squid("report", REMUS100, "--json", cwd=here, timeout=900.0)
    assert done.returncode == 0, done.stderr
    page = here / json.loads(done.stdout)["report"]
    assert page == here / "build" / "remus100" / "design" / "report.html"
    text = page.read_text(encoding="utf-8")
    anchors = re.findall(r'<section id="([\w-]+)"', text)
    assert anchors[0] == "turns" and len(set(anchors)) == len(anchors)
    assert {name.split("-")[0] for name in anchors[1:]} == {"depth", "heading"}
    figures = re.findall(r'<figure id="([\w-]+)"', text)
    assert "turn" in figures and len(set(figures)) == len(figures)
    assert turns_of(text) == ("10.22", "12")
    assert FAILED not in text
    for words in (["--paper"], ["--beside", "pitch"]):
        done = run_squid("report", REMUS100, *words, "--json", cwd=here)
        refusal(done, "argument", 64)
        assert messages(done) == snapshot
