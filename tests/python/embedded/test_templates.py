"""Statements of docs/embedding.md about the templates, which test_shells.py runs, and its example."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from conftest import SQUID, Run
from embedded import call
from fly.stages import ROOT
from native import program

pytestmark = pytest.mark.change

TEMPLATES = sorted((ROOT / "docs" / "embedding").glob("*.cpp"))


@pytest.fixture(scope="module")
def folder(run_squid: Run, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the source of the committed design."""
    folder = tmp_path_factory.mktemp("c")
    done = run_squid("export", SQUID, "--out", SQUID / "frozen", "--to", folder)
    assert done.returncode == 0, done.stderr
    return folder


def test_the_page_names_each_template_and_says_what_stands_in() -> None:
    page = (ROOT / "docs" / "embedding.md").read_text(encoding="utf-8")
    assert len(TEMPLATES) == 2
    assert all(f"embedding/{template.name}" in page for template in TEMPLATES)
    assert re.search(r"stand\s+in", page)


def test_the_example_of_the_page_compiles_and_runs(folder: Path) -> None:
    page = (ROOT / "docs" / "embedding.md").read_text(encoding="utf-8")
    (example,) = re.findall(r"```c\n(.*?)```", page, re.DOTALL)
    (folder / "example.c").write_text(example, encoding="utf-8")
    flags = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-ffp-contract=off"]
    call(program("gcc", "gcc"), *flags, "-o", folder / "example", folder / "example.c", folder / "squid.c")
    assert float(call(folder / "example")) > 0.0
