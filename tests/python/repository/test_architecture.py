"""Forbidden dependencies between crates, cycles between files of a crate, and folders with too many files."""

from __future__ import annotations

import json
import re
import subprocess
from functools import cache
from pathlib import Path

import pytest
from fly.stages import ROOT
from imports import Crate

pytestmark = pytest.mark.change

NEVER = {
    "squid-fmu-plant": {
        "squid-lpv",
        "clarabel",
        "faer",
        "squid-blas-symbols",
        "squid",
        "squid-scheduled",
    },
    "squid-fmu-controller": {
        "squid-lpv",
        "clarabel",
        "faer",
        "squid-blas-symbols",
        "squid",
        "squid-auv",
    },
    "squid-fmu-loop": {"squid-lpv", "clarabel", "faer", "squid-blas-symbols", "squid"},
    "squid-auv": {
        "squid-base",
        "squid-lpv",
        "squid-scheduled",
        "squid-fmi2",
        "squid-model-description",
        "clarabel",
    },
    "squid-lpv": {"squid-auv", "squid-scheduled", "squid-fmi2", "squid-model-description"},
    "squid-scheduled": {"squid-auv", "squid-lpv", "squid-fmi2", "squid-model-description", "clarabel"},
    "squid-fmi2": {"squid-auv", "squid-lpv", "squid-scheduled", "clarabel"},
    "squid-design": {
        "clap",
        "indicatif",
        "zip",
        "squid-fmi2",
        "squid-fmu-plant",
        "squid-report",
        "squid-package",
    },
    "squid-embedded": {
        "squid-auv",
        "squid-lpv",
        "squid-certificate",
        "squid-fmi2",
        "clap",
        "clarabel",
        "squid-design",
    },
    "squid-flight": {"squid-lpv", "clap", "zip", "squid-design"},
    "squid-report": {"clap", "zip", "squid-fmi2", "squid-package", "squid-paper"},
    "squid-paper": {"clap", "indicatif", "zip", "squid-fmi2", "squid-package"},
    "squid-campaign": {"clap", "indicatif", "zip", "squid-fmi2", "squid-report", "squid-package"},
    "squid-python": {"clap", "indicatif", "zip", "squid-fmi2", "squid-report", "squid-package"},
    "squid-problem": {"clap", "indicatif", "zip", "squid-auv", "squid-scheduled", "squid-design"},
    "squid-proof": {
        "squid-auv",
        "squid-base",
        "squid-scheduled",
        "squid-fmi2",
        "squid-model-description",
        "tempfile",
        "toml",
    },
    "squid-pid": {
        "squid-scheduled",
        "squid-certificate",
        "squid-proof",
        "squid-design",
        "squid-fmi2",
        "squid-model-description",
        "clap",
    },
    "squid-finding": {
        "squid-base",
        "squid-auv",
        "squid-lpv",
        "squid-certificate",
        "squid-scheduled",
        "squid-fmi2",
    },
    "squid-base": {"squid-auv", "squid-lpv", "squid-certificate", "squid-scheduled", "squid-fmi2"},
    "squid-tune": {"clap", "indicatif", "zip", "squid-fmi2", "squid-report", "squid-package"},
    "squid-package": {"clap", "indicatif", "squid-paper"},
    "squid-sea": {
        "squid-auv",
        "squid-lpv",
        "squid-scheduled",
        "squid-signals",
        "squid-fmi2",
        "squid-model-description",
        "nalgebra",
    },
    "squid-certificate": {
        "squid-auv",
        "squid-lpv",
        "squid-scheduled",
        "squid-fmi2",
        "squid-model-description",
        "clarabel",
        "faer",
    },
    "squid-model-description": {"squid-auv", "squid-lpv", "squid-scheduled", "squid-fmi2"},
}
MEMBERS = sorted(path.parent.relative_to(ROOT) for path in ROOT.glob("*/src")) + sorted(
    path.parent.relative_to(ROOT) for path in ROOT.glob("crates/*/src")
)
MOST_FILES = 15
LONGEST_LINE = 120
WRITTEN = (".rs", ".py", ".md", ".toml", ".css", ".js")
WHOLE = re.compile(r"\s*(\||[\w.]+ = [\[{\"])")
"""What cannot be broken: a row of a table in Markdown, a value in TOML."""
FORBIDDEN_NAMES = {"openblas-src", "netlib-src", "intel-mkl-src", "bindgen", "cmake"}


@cache
def reached_from(crate: str) -> frozenset[str]:
    """Return the names of all packages that a crate links, itself included."""
    words = ["cargo", "tree", "--edges", "normal", "--package", crate, "--prefix", "none", "--format", "{p}"]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=True)
    return frozenset(line.split()[0] for line in done.stdout.splitlines() if line)


@pytest.mark.parametrize("crate", NEVER)
def test_arrow_does_not_exist(crate: str) -> None:
    assert not NEVER[crate] & reached_from(crate)


def test_the_arrows_that_do_exist_are_seen() -> None:
    """The test above can fail: it sees dependencies that exist."""
    assert {"squid-lpv", "squid-auv", "squid-fmi2", "clarabel", "squid-design"} <= reached_from("squid")
    assert {"squid-auv", "squid-fmi2"} <= reached_from("squid-fmu-plant")


@pytest.mark.parametrize(
    "file", ["crates/python/src/plants.rs", "crates/python/src/job.rs", "tools/src/verbs/lpv.rs"]
)
def test_problems_of_any_plant_pass_no_vehicle(file: str) -> None:
    """Command and Python package depend on vehicles, but not on the path to a general problem."""
    assert not re.search(r"\b(squid_design|squid_auv)::", (ROOT / file).read_text(encoding="utf-8"))


def test_every_forbidden_crate_exists() -> None:
    """A misspelt name would never be found."""
    words = ["cargo", "metadata", "--format-version", "1"]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=True)
    known = {package["name"] for package in json.loads(done.stdout)["packages"]}
    assert set().union(*NEVER.values()) <= known


def test_nothing_needs_fortran_cmake_or_libclang() -> None:
    words = ["cargo", "tree", "--edges", "normal,build", "--package", "squid", "--prefix", "none"]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=True)
    assert not FORBIDDEN_NAMES & {line.split()[0] for line in done.stdout.splitlines() if line}


def with_features(*of: str) -> set[str]:
    """Return all packages that cargo compiles for some packages, each with its features."""
    words = ["cargo", "tree", *of, "--prefix", "none", "--format", "{p} {f}"]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=True)
    return {line.removesuffix(" (*)") for line in done.stdout.splitlines() if line}


@pytest.mark.parametrize("package", ["squid", "squid-python"])
def test_what_ships_is_built_of_the_crates_that_the_tests_are_built_of(package: str) -> None:
    """A feature that only tests request makes all dependents compile twice."""
    shipped = with_features("--package", package, "--edges", "normal,build")
    assert shipped <= with_features("--workspace", "--edges", "normal,build,dev")


@pytest.mark.parametrize("member", MEMBERS, ids=str)
def test_no_circle_between_files(member: Path) -> None:
    circles = Crate(ROOT / member / "src").circles()
    assert not circles, "\n".join(["files that use one another:", *circles])


@pytest.mark.parametrize(
    ("one", "expected"),
    [
        ("use crate::two::Thing;", ["one.rs -> two.rs -> one.rs"]),
        ("use crate::{three as z, Thing};", ["one.rs -> two.rs -> one.rs"]),
        ("use super::two; fn f() { two::g() }", ["one.rs -> two.rs -> one.rs"]),
        ("fn f(_: crate::two::Thing) {}", ["one.rs -> two.rs -> one.rs"]),
        ('// crate::two::Thing\nconst WORDS: &str = "crate::two::Thing";', []),
        ("#[cfg(test)] mod tests { use crate::Thing; }", []),
        ("pub use crate::two::Thing;", []),
        ("use crate::inner::Other;", []),
        ("use crate::inner::deep::Other;", ["inner/deep.rs -> one.rs -> inner/deep.rs"]),
    ],
)
def test_a_circle_is_seen(tmp_path: Path, one: str, expected: list[str]) -> None:
    """Cycles through a file path, a name re-exported by lib.rs, and an alias are seen; not those in text or tests."""
    texts = {
        "lib.rs": "mod one; mod two; mod three; mod inner; pub use two::Thing;",
        "one.rs": one,
        "two.rs": "use crate::one; pub struct Thing;",
        "three.rs": "",
        "inner.rs": "mod deep; pub struct Other;",
        "inner/deep.rs": "use crate::one::f; pub struct Other;",
    }
    (tmp_path / "inner").mkdir()
    for name, text in texts.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    assert Crate(tmp_path).circles() == expected


@pytest.mark.parametrize("member", MEMBERS, ids=str)
def test_folders_are_not_too_full(member: Path) -> None:
    folders = {path.parent for path in (ROOT / member / "src").rglob("*.rs")}
    files = {folder.relative_to(ROOT): len(list(folder.glob("*.rs"))) for folder in folders}
    assert not {str(folder): count for folder, count in files.items() if count > MOST_FILES}


def test_lines_are_not_too_long() -> None:
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    long = []
    for name in (name for name in listed.splitlines() if name.endswith(WRITTEN)):
        whole = WHOLE if name.endswith((".md", ".toml")) else re.compile("(?!)")
        lines = enumerate((ROOT / name).read_text(encoding="utf-8").splitlines(), 1)
        long += [f"{name}:{n}" for n, line in lines if len(line) > LONGEST_LINE and not whole.match(line)]
    assert not long
