"""The example in docs/plants.md: its commands run, and give its output."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from conftest import Run
from fly.stages import ROOT

pytestmark = pytest.mark.change

NUMBER = re.compile(r"-?\d+\.\d+")
SOLVER_ACCURACY = 1e-4
"""Another processor rounds otherwise, and the controller follows from the last digits of the least gamma."""


def blocks_of_the_example() -> tuple[str, list[list[str]], list[str]]:
    """Return problem file, commands and output of the section on synthesis."""
    page = (ROOT / "docs" / "plants.md").read_text(encoding="utf-8")
    section = page.split("\n## Synthesis\n")[1].split("\n## ")[0]
    problem, commands, output = (
        re.search(rf"```{kind}\n(.*?)```", section, re.DOTALL)[1] for kind in ("json", "sh", "text")
    )
    words = [line.split("#")[0].split() for line in commands.splitlines()]
    assert all(line[:2] == ["cargo", "squid"] for line in words)
    return problem, [line[2:] for line in words], output.splitlines()


def test_the_example_of_a_plant(run_squid: Run, tmp_path: Path) -> None:
    problem, commands, shown = blocks_of_the_example()
    (tmp_path / "spring.json").write_text(problem, encoding="utf-8")
    here = [[word.replace("spring", str(tmp_path / "spring"), 1) for word in words] for words in commands]
    synth, check = (run_squid(*words) for words in here)
    assert (synth.returncode, check.returncode) == (0, 0), synth.stderr + check.stderr
    for line, printed in zip(shown, synth.stdout.splitlines(), strict=False):
        start = line.removesuffix("...")
        assert NUMBER.sub("x", printed).startswith(NUMBER.sub("x", start)), printed
        numbers = [float(number) for number in NUMBER.findall(start)]
        found = [float(number) for number in NUMBER.findall(printed)][: len(numbers)]
        assert found == pytest.approx(numbers, rel=SOLVER_ACCURACY)
    assert shown[0] == "feasible" and "PROVED" in shown[-1] and "PROVED" in check.stdout
    names = {path.name for path in (tmp_path / "spring").glob("[!.]*")}
    assert names == {"report.json", "controller.json", "certificate.json"}
