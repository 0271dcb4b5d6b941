"""`squid export` and `squid verify --c`: the files written, the proof, and refusals."""

from __future__ import annotations

import hashlib
import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from claims import claim
from conftest import PITCHING, SQUID, Run, kept, masked, messages, named, refusal
from embedded import Exported
from fly.stages import ROOT
from syrupy.assertion import SnapshotAssertion

pytestmark = pytest.mark.change

FROZEN = SQUID / "frozen"
LAST = "add(ANTI_WINDUP, got, state->x);\n    return SQUID_OK;\n}"
"""The end of the source."""


@pytest.fixture(scope="module")
def committed(run_squid: Run, tmp_path_factory: pytest.TempPathFactory) -> Exported:
    """Return the source of the committed design; it must not be changed."""
    folder = tmp_path_factory.mktemp("committed") / "c"
    done = run_squid("export", SQUID, "--out", FROZEN, "--to", folder, "--language", "c")
    assert done.returncode == 0, done.stderr
    return Exported(folder, "squid")


@pytest.fixture
def copied(committed: Exported, tmp_path: Path) -> Exported:
    """Return a copy that a test may modify."""
    return Exported(Path(shutil.copytree(committed.folder, tmp_path / "c")), committed.name)


def test_writes_header_source_design_and_certificate(committed: Exported) -> None:
    names = {path.name for path in committed.folder.iterdir() if not path.name.startswith(".")}
    assert names == {"squid.h", "squid.c", "controller.json", "certificate.json"}
    assert (committed.folder / "certificate.json").read_bytes() == (FROZEN / "certificate.json").read_bytes()


def test_the_header_says_what_is_proved_and_no_more(run_squid: Run, tmp_path: Path) -> None:
    """The sentences are those of `squid design`, and the hash is that of the file."""
    packages = kept(run_squid, ROOT / "vehicles" / "sparus2")
    exported = Exported.of(run_squid, packages, tmp_path)
    text = " ".join(exported.header.read_text(encoding="utf-8").replace("\n *", " ").split())
    claims = text.split(" Proved: ")[1].split(" */")[0]
    certificate = (exported.folder / "certificate.json").read_bytes()
    assert certificate == (packages.folder / "certificate.json").read_bytes()
    assert hashlib.sha256(certificate).hexdigest() in claims
    assert exported.constant("GAMMA") == claim(json.loads(certificate), "gain")["gamma"]
    assert exported.constant("CERTIFIED") == 1
    printed = " ".join((packages.folder / "design.txt").read_text(encoding="utf-8").split())
    said = "PROVED in exact arithmetic"
    sentences = re.findall(rf"{said}: (.*?)(?= {said}| This applies to)", claims)
    assert len(sentences) == claims.count(said) >= 1
    assert all(sentence in printed for sentence in sentences)


@pytest.mark.parametrize("squared", [False, True])
def test_the_header_says_what_to_link(
    run_squid: Run, quick_vehicle: Path, tmp_path: Path, squared: bool
) -> None:
    """A thruster with a square law needs -lm: without optimisation gcc does not inline `sqrt`."""
    vehicle, out = Path(shutil.copytree(quick_vehicle, tmp_path / "squid")), tmp_path / "out"
    if squared:
        path, head = vehicle / "vehicle.toml", 'name = "lower"\n'
        text = path.read_text(encoding="utf-8")
        assert text.count(head) == 1
        law = 'T_nn = { value = 1e-4, unit = "N/rpm2", source = "test" }\n'
        path.write_text(text.replace(head, head + law), encoding="utf-8")
    for verb in (("design", "--no-advise"), ("export",)):
        done = run_squid(verb[0], vehicle, *verb[1:], "--out", out)
        assert done.returncode == 0, done.stderr
    exported = Exported(out / "c", "squid")
    assert ("-lm" in exported.header.read_text(encoding="utf-8")) == squared
    library = tmp_path / "squid.so"
    strict = [
        "cc",
        "-std=c99",
        "-O0",
        "-shared",
        "-fPIC",
        "-Wl,--no-undefined",
        exported.source,
        "-o",
        library,
    ]
    alone = subprocess.run(strict, capture_output=True, text=True, check=False)
    linked = subprocess.run([*strict, "-lm"], capture_output=True, text=True, check=False)
    assert linked.returncode == 0, linked.stderr
    assert (alone.returncode == 0) == (not squared), alone.stderr


def test_the_header_says_the_sign_of_each_command(committed: Exported, snapshot: SnapshotAssertion) -> None:
    """Squid's lower thruster is below the centre of gravity, the others above it; all push forward."""
    text = committed.header.read_text(encoding="utf-8")
    said = {name: way for way, name in re.findall(r"/\* (positive .*) \*/\n +\w+ (\w+);", text)}
    ways = {name: words.split()[-1] for name, words in said.items()}
    assert ways == {"lower": "up", "upper_port": "down", "upper_starboard": "down"}
    assert said == snapshot


def test_the_source_is_proved(committed: Exported, run_squid: Run, snapshot: SnapshotAssertion) -> None:
    done = run_squid("verify", "--c", committed.source, "--vehicle", SQUID)
    assert done.returncode == 0, done.stderr
    assert masked(named(done.stdout, C=committed.folder)) == snapshot


def test_a_source_of_floats_is_proved(run_squid: Run, tmp_path: Path) -> None:
    assert run_squid("export", SQUID, "--out", FROZEN, "--to", tmp_path, "--real", "float").returncode == 0
    done = run_squid("verify", "--c", tmp_path / "squid.c")
    assert done.returncode == 0 and "PROVED" in done.stdout, done.stderr


def test_another_layout_is_the_same_source(copied: Exported, run_squid: Run) -> None:
    """White space, comments, and the notation of numbers do not matter."""
    text = copied.source.read_text(encoding="utf-8")
    text = re.sub(r"/\*.*?\*/", "/* other words */", text, flags=re.DOTALL).replace("    ", "\t\n ")
    number = re.search(r"SCALE\[3\] = {\s*(0x\S+?),", text)[1]
    text = text.replace(number, repr(float.fromhex(number)))
    copied.source.write_text(text, encoding="utf-8")
    assert run_squid("verify", "--c", copied.source).returncode == 0


@pytest.mark.parametrize("table", ["INTO_LOOP", "LOOP", "OUTPUT", "UPDATE", "ANTI_WINDUP", "TRIM", "MAXIMUM"])
def test_a_number_that_was_changed_is_named(copied: Exported, run_squid: Run, table: str) -> None:
    head, tail = copied.source.read_text(encoding="utf-8").split(f"real {table}[")
    number = re.search(r"0x1\.\w+p[+-]\d+", tail)[0]
    digit = "1" if number[4] != "1" else "2"
    changed = tail.replace(number, number[:4] + digit + number[5:], 1)
    copied.source.write_text(f"{head}real {table}[{changed}", encoding="utf-8")
    reason = refusal(run_squid("verify", "--c", copied.source, "--json"), "source")["reason"]
    assert f" {table} " in reason and number in reason
    assert int(re.search(r"line (\d+)", reason)[1]) > head.count("\n")


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("rho - t->rho", "t->rho - rho"),
        ("    put_out(", "// \\\n    put_out("),
        ("#include <float.h>", "#if 0\n#include <float.h>"),
        (f"{LAST}\n", f"{LAST}\nint more;\n"),
    ],
    ids=["order", "comment", "include", "end"],
)
def test_code_that_was_changed_is_reported(
    copied: Exported, run_squid: Run, old: str, new: str, snapshot: SnapshotAssertion
) -> None:
    text = copied.source.read_text(encoding="utf-8")
    assert old in text
    copied.source.write_text(new.join(text.rsplit(old, 1)), encoding="utf-8")
    done = run_squid("verify", "--c", copied.source, "--json")
    refusal(done, "source")
    assert messages(done, C=copied.folder) == snapshot


def test_a_header_that_was_changed_is_reported(copied: Exported, run_squid: Run) -> None:
    text = copied.header.read_text(encoding="utf-8")
    for old, new in (("x[", "x[1 + "), ('SHA256 "', 'SHA256 "0')):
        copied.header.write_text(text.replace(old, new), encoding="utf-8")
        done = run_squid("verify", "--c", copied.source, "--json")
        assert "squid.h: line" in refusal(done, "source")["reason"]


def test_the_certificate_is_of_the_controller(copied: Exported, run_squid: Run) -> None:
    """The design next to the source is changed with it as far as possible."""
    path = copied.folder / "controller.json"
    design = json.loads(path.read_text(encoding="utf-8"))
    design["lft"]["A"][0][0] *= 1.0 + 1e-12
    path.write_text(json.dumps(design), encoding="utf-8")
    done = run_squid("verify", "--c", copied.source, "--json")
    assert "matrix A" in refusal(done, "mismatch")["reason"]


@pytest.mark.parametrize("name", ["controller.json", "certificate.json"])
def test_what_is_not_beside_the_source_is_asked_for(
    copied: Exported, run_squid: Run, name: str, snapshot: SnapshotAssertion
) -> None:
    (copied.folder / name).unlink()
    done = run_squid("verify", "--c", copied.source, "--json")
    assert name in refusal(done, "not_beside")["reason"]
    assert messages(done, C=copied.folder) == snapshot


def test_scales_of_another_vehicle_are_reported(
    copied: Exported, run_squid: Run, snapshot: SnapshotAssertion
) -> None:
    """Without the vehicle, values that the proof does not cover are taken from the design next to the source."""
    done = run_squid("verify", "--c", copied.source, "--vehicle", PITCHING, "--json")
    refusal(done, "not_of_inputs")
    assert messages(done, C=copied.folder) == snapshot


def test_an_uncertified_controller_needs_to_be_allowed(run_squid: Run, tmp_path: Path) -> None:
    design = Path(shutil.copytree(FROZEN, tmp_path / "frozen"))
    (design / "certificate.json").unlink()
    words = ("export", SQUID, "--out", design, "--to", tmp_path / "c")
    refusal(run_squid(*words, "--json"), "uncertified")
    assert not (tmp_path / "c").exists()
    assert run_squid(*words, "--allow-uncertified").returncode == 0
    header = (tmp_path / "c" / "squid.h").read_text(encoding="utf-8")
    assert "UNCERTIFIED" in header and "PROVED" not in header and "#define SQUID_CERTIFIED 0" in header
    refusal(run_squid("verify", "--c", tmp_path / "c" / "squid.c", "--json"), "not_beside")


def test_what_is_wrong_is_reported_and_nothing_written(
    run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    to = tmp_path / "c"
    (tmp_path / "file").write_text("mine", encoding="utf-8")
    for key, words in (
        ("usage", ("--language", "fortran", "--to", to)),
        ("not_designed", ("--out", tmp_path / "none", "--to", to)),
        ("unwritable", ("--out", FROZEN, "--to", tmp_path / "file")),
    ):
        done = run_squid("export", SQUID, *words, "--json")
        refusal(done, key, 64 if key == "usage" else 1)
        assert messages(done, TMP=tmp_path) == snapshot(name=key)
    assert {path.name for path in tmp_path.iterdir()} == {"file"}
    done = run_squid("verify")
    assert done.returncode == 64


def test_a_failure_leaves_an_earlier_source_whole(copied: Exported, run_squid: Run) -> None:
    copied.header.unlink()
    copied.header.mkdir()
    before = copied.source.read_bytes()
    done = run_squid("export", SQUID, "--out", FROZEN, "--to", copied.folder, "--real", "float", "--json")
    refusal(done, "unwritable")
    assert copied.source.read_bytes() == before
    assert not list(copied.folder.glob(".squid-[!l]*"))
