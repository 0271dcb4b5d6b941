"""Arrows that must never exist between the crates."""

from __future__ import annotations

import json
import subprocess
from functools import cache

import pytest
from fly.stages import ROOT

NEVER = {
    "fmu-plant": {"lpv", "clarabel", "faer", "blas-symbols", "squid", "scheduled"},
    "fmu-controller": {"lpv", "clarabel", "faer", "blas-symbols", "squid", "auv"},
    "fmu-squid": {"lpv", "clarabel", "faer", "blas-symbols", "squid"},
    "auv": {"lpv", "scheduled", "fmi2", "model-description", "clarabel"},
    "lpv": {"auv", "scheduled", "fmi2", "model-description"},
    "scheduled": {"auv", "lpv", "fmi2", "model-description", "clarabel"},
    "fmi2": {"auv", "lpv", "scheduled", "clarabel"},
    "squid-design": {"clap", "indicatif", "plotters", "zip", "fmi2", "fmu-plant", "squid-report", "squid-package"},
    "squid-flight": {"lpv", "clap", "plotters", "zip", "squid-design"},
    "squid-report": {"clap", "zip", "fmi2", "squid-package"},
    "squid-package": {"clap", "indicatif"},
    "certificate": {"auv", "lpv", "scheduled", "fmi2", "model-description", "clarabel", "faer"},
    "model-description": {"auv", "lpv", "scheduled", "fmi2"},
}
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
    """The test above can fail: it sees the arrows that are there."""
    assert {"lpv", "auv", "fmi2", "clarabel", "fmu-plant", "squid-design"} <= reached_from("squid")
    assert {"auv", "fmi2"} <= reached_from("fmu-plant")


def test_every_forbidden_crate_exists() -> None:
    """A misspelt name would never be reached."""
    words = ["cargo", "metadata", "--format-version", "1"]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=True)
    known = {package["name"] for package in json.loads(done.stdout)["packages"]}
    assert set().union(*NEVER.values()) <= known


def test_nothing_needs_fortran_cmake_or_libclang() -> None:
    words = ["cargo", "tree", "--edges", "normal,build", "--package", "squid", "--prefix", "none"]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=True)
    assert not FORBIDDEN_NAMES & {line.split()[0] for line in done.stdout.splitlines() if line}
