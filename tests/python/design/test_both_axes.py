"""The autopilot of depth and that of heading of REMUS 100 in one FMU: packed, flown and proved again."""

from __future__ import annotations

import json
import re
import shutil
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from conftest import REMUS100, Run, heading_alone, kept, rewritten
from fly.master import Slave
from fmpy import read_model_description
from fmpy.validation import validate_fmu

pytestmark = pytest.mark.change

BOTH = ("--design", "depth", "--heading", "heading")
NAME = "remus100_controller.fmu"


@dataclass(frozen=True)
class Made:
    """The FMUs of the controllers: of each axis, and of both."""

    depth: Path
    heading: Path
    both: Path
    build: Path
    """The default directory of the designs, as `squid` finds it from its parent."""
    answer: dict
    """What `squid package --json` says of both."""

    def copy(self, folder: Path) -> Path:
        """Copy the designs for a test that spoils them; return where `squid` is to be run."""
        shutil.copytree(self.build, folder / "build", ignore=shutil.ignore_patterns("*.fmu"))
        return folder


@pytest.fixture(scope="session")
def made(run_squid: Run, tmp_path_factory: pytest.TempPathFactory) -> Made:
    """Package both axes in a folder with a copy of both designs."""
    alone = {
        "depth": kept(run_squid, REMUS100, "--design", "depth").folder,
        "heading": heading_alone(run_squid),
    }
    here = tmp_path_factory.mktemp("both")
    for name, folder in alone.items():
        ignored = shutil.ignore_patterns("*.fmu", "*.ssp", "*.txt")
        shutil.copytree(folder, here / "build" / "remus100" / name, ignore=ignored)
    done = run_squid("package", REMUS100, *BOTH, "--json", cwd=here)
    assert done.returncode == 0, done.stderr
    depth, heading = (folder / NAME for folder in alone.values())
    both = here / "build" / "remus100" / "depth" / NAME
    return Made(depth, heading, both, here / "build", json.loads(done.stdout))


def test_both_are_packed_beside_the_first_design(run_squid: Run, made: Made, tmp_path: Path) -> None:
    files = ["remus100.fmu", "remus100.ssp", NAME, "remus100_plant.fmu"]
    assert sorted(made.answer["files"]) == [str(Path("build", "remus100", "depth", name)) for name in files]
    for lines in (made.answer["claims"], made.answer["proof"].splitlines()):
        axes = [line.split(": ")[0] for line in lines]
        assert set(axes) == {"depth", "heading"} and axes == sorted(axes), lines
        assert all(": certified: " in line for line in lines)
    with zipfile.ZipFile(made.both) as fmu:
        for index, design in (("", "depth"), ("_2", "heading")):
            for name in ("controller", "certificate"):
                stored = made.build / "remus100" / design / f"{name}.json"
                assert fmu.read(f"resources/{name}{index}.json") == stored.read_bytes()
        page = fmu.read("documentation/index.html").decode()
    assert "an LPV controller of depth and one of heading" in page
    assert "depth: Bound of the L2 gain" in page and "heading: Bound of the L2 gain" in page
    assert "Each axis is proved alone" in page
    done = run_squid("package", REMUS100, *BOTH, "--descriptions", tmp_path, cwd=made.build.parent)
    assert done.returncode == 0, done.stderr
    with zipfile.ZipFile(made.both) as fmu:
        described = tmp_path / NAME.replace(".fmu", ".xml")
        assert described.read_bytes() == fmu.read("modelDescription.xml")


def test_it_is_legal_and_commands_as_each_does_alone(made: Made) -> None:
    """To the bit, whatever the other measures."""
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


def test_both_are_proved_again(run_squid: Run, made: Made) -> None:
    done = run_squid("verify", made.both, "--json")
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    each = [json.loads(run_squid("verify", fmu, "--json").stdout) for fmu in (made.depth, made.heading)]
    assert all("axes" not in one for one in each)
    assert found.pop("axes") == [
        {**one, "axis": name} for one, name in zip(each, ("depth", "heading"), strict=True)
    ]
    assert found == each[0]
    done = run_squid("verify", made.both, "--vehicle", REMUS100, *BOTH)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    for name in ("depth", "heading"):
        own = [line for line in lines if line.startswith(f"{name}: ")]
        assert any(line.startswith(f"{name}: PROVED: gain") for line in own)
        assert any(f"follows from vehicle.toml and design '{name}'" in line for line in own)
        lines = [line for line in lines if line not in own]
    assert len(lines) == 1 and lines[0].startswith("Each axis is proved alone")


def amplify(content: bytes) -> bytes:
    """Change the law of control: another digit of a number of it."""
    controller = json.loads(content)
    controller["lft"]["A"][0][0] *= 1 + 1e-15
    return json.dumps(controller).encode()


def rescale(content: bytes) -> bytes:
    """Change what the certificate does not have: the scale of a measurement."""
    controller = json.loads(content)
    controller["controller_inputs"][0]["scale"] /= 50
    return json.dumps(controller).encode()


@pytest.mark.parametrize(
    ("name", "change", "said"),
    [
        ("controller_2.json", amplify, "matrix A differs"),
        ("controller_2.json", rescale, "the GUID differs"),
        ("controller_2.json", lambda content: content.replace(b"heading", b"headinx", 1), "differs"),
        ("controller_2.json", lambda _: None, "the GUID differs"),
        ("certificate_2.json", lambda _: None, "it contains no resources/certificate_2.json"),
        ("certificate_2.json", lambda content: content.replace(b"1", b"2", 1), ""),
    ],
)
def test_what_was_changed_is_refused(
    run_squid: Run, made: Made, tmp_path: Path, name: str, change: Callable[[bytes], bytes | None], said: str
) -> None:
    spoilt = rewritten(made.both, tmp_path / "spoilt.fmu", f"resources/{name}", change)
    done = run_squid("verify", spoilt)
    assert done.returncode == 1 and said in done.stderr and "panicked" not in done.stderr
    assert "PROVED" not in done.stdout


def test_a_third_axis_is_refused(run_squid: Run, made: Made, tmp_path: Path) -> None:
    spoilt = tmp_path / "spoilt.fmu"
    shutil.copy(made.both, spoilt)
    with zipfile.ZipFile(spoilt, "a") as fmu:
        fmu.writestr("resources/controller_3.json", "{}")
    done = run_squid("verify", spoilt)
    assert done.returncode == 1 and "it contains resources/controller_3.json; at most two axes" in done.stderr


def test_an_axis_without_proof_is_packed_only_if_asked(run_squid: Run, made: Made, tmp_path: Path) -> None:
    here = made.copy(tmp_path)
    (here / "build" / "remus100" / "heading" / "certificate.json").unlink()
    done = run_squid("package", REMUS100, *BOTH, cwd=here)
    folder = Path("build", "remus100", "heading")
    assert done.returncode == 1 and f"the controller in {folder} is not certified" in done.stderr
    fmu = here / "build" / "remus100" / "depth" / NAME
    assert not fmu.exists()
    done = run_squid("package", REMUS100, *BOTH, "--allow-uncertified", cwd=here)
    assert done.returncode == 0, done.stderr
    assert "depth: certified: " in done.stdout and "heading: UNCERTIFIED: " in done.stdout
    assert {v.name: v.start for v in read_model_description(fmu).modelVariables if "certified" in v.name} == {
        "gamma_certified": "true",
        "heading_gamma_certified": "false",
    }
    done = run_squid("verify", fmu)
    assert done.returncode == 1 and "it contains no resources/certificate_2.json" in done.stderr


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (
            ["--design", "depth", "--heading", "design"],
            64,
            "--heading is design; it must be a design that tracks",
        ),
        (
            ["--design", "heading", "--heading", "heading"],
            64,
            "--design is heading; it must be a design of pitch",
        ),
        (["--design", "depth", "--heading", "none"], 1, "none.toml: there is no such file"),
        (
            ["--design", "heading", "--kind", "me"],
            64,
            "--kind is me; it must be cs or both where a controller is packed alone",
        ),
    ],
)
def test_what_cannot_be_packed_together_says_why(
    run_squid: Run, tmp_path: Path, words: list[str], code: int, said: str
) -> None:
    done = run_squid("package", REMUS100, *words, cwd=tmp_path)
    assert done.returncode == code and said in done.stderr
    assert not list(tmp_path.iterdir())


def test_axes_have_one_clock(run_squid: Run, tmp_path: Path) -> None:
    vehicle = Path(shutil.copytree(REMUS100, tmp_path / "vehicle", ignore=shutil.ignore_patterns("frozen")))
    design = vehicle / "heading.toml"
    text = design.read_text(encoding="utf-8")
    assert text.count("sample_time = 0.02\n") == 1
    design.write_text(text.replace("sample_time = 0.02\n", "sample_time = 0.04\n"), encoding="utf-8")
    done = run_squid("package", vehicle, *BOTH, cwd=tmp_path)
    said = (
        "'autopilot.sample_time' is 0.02 s in depth.toml and 0.04 s in heading.toml; both axes have one clock"
    )
    assert done.returncode == 1 and said in done.stderr


def test_axes_have_a_speed_in_common(run_squid: Run, tmp_path: Path) -> None:
    vehicle = Path(shutil.copytree(REMUS100, tmp_path / "vehicle", ignore=shutil.ignore_patterns("frozen")))
    design = vehicle / "heading.toml"
    text = design.read_text(encoding="utf-8")
    for key, value in (("speed_min", 2.3), ("speed_max", 2.5), ("speed_from", 2.35), ("speed_to", 2.45)):
        text, count = re.subn(rf"(?m)^{key} = [0-9.]+", f"{key} = {value}", text)
        assert count == 1, key
    design.write_text(text, encoding="utf-8")
    done = run_squid("package", vehicle, *BOTH, cwd=tmp_path)
    assert done.returncode == 1
    assert (
        "depth.toml is of 1.4 to 2.2 m/s and heading.toml is of 2.3 to 2.5 m/s: no speed is in the"
        in done.stderr
    )


def test_verify_wants_the_designs_of_the_axes_that_are_there(run_squid: Run, made: Made) -> None:
    certificate = made.build / "remus100" / "depth" / "certificate.json"
    depth = ("--vehicle", REMUS100, "--design", "depth")
    heading = ("--heading", "heading")
    for words, code, said in [
        (
            (made.both, *depth),
            1,
            "its second axis is of design 'heading'; name the design of this axis with --heading",
        ),
        (
            (made.depth, *depth, *heading),
            1,
            "it has no second axis for the design of --heading; leave out --heading",
        ),
        ((certificate, *depth, *heading), 1, "it has no second axis for the design of --heading"),
        (
            (made.both, *depth, "--heading", "depth"),
            64,
            "--heading is depth; it must be a design that tracks",
        ),
        ((made.both, *heading), 64, "--vehicle <DIR>"),
    ]:
        done = run_squid("verify", *words)
        assert done.returncode == code and said in done.stderr, done.stderr
        assert "PROVED" not in done.stdout
