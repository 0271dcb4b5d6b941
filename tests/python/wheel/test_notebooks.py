"""The notebooks of the documentation run, and give the stored output."""

from __future__ import annotations

import json
import re
from types import ModuleType

import pytest
from fly.stages import ROOT

pytestmark = pytest.mark.change

GOLDEN = 1e-3
"""Relative: processors round differently, and the solver's iterations amplify this."""
GRID = 1e-3
"""Relative: so much less than the norm a gain on the grid may be."""


def cells_of(name: str) -> list[dict]:
    """Return the cells of a notebook."""
    return json.loads((ROOT / "docs" / f"{name}.ipynb").read_text(encoding="utf-8"))["cells"]


def run(cells: list[dict]) -> dict:
    """Run a notebook; return its variables."""
    held: dict = {}
    for cell in cells:
        if cell["cell_type"] == "code":
            exec("".join(cell["source"]), held)
    return held


def printed(cells: list[dict]) -> str:
    """Return the stored output of a notebook."""
    outputs = [out for cell in cells for out in cell.get("outputs", [])]
    return "".join(line for out in outputs for line in out.get("text", []))


def test_the_tour(sq: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MPLBACKEND", "agg")
    monkeypatch.chdir(ROOT)
    cells = cells_of("tour")
    held = run(cells)
    design, theorem = held["design"], held["theorem"]
    assert theorem.gamma == design.gamma
    assert {row["outcome"] for row in design.verdict} == {"met", "reported"}
    frozen = json.loads(
        (ROOT / "vehicles" / "squid" / "frozen" / "controller.json").read_text(encoding="utf-8")
    )
    assert design.gamma == pytest.approx(frozen["gamma"]["bound"], rel=GOLDEN)
    assert any("image/png" in out.get("data", {}) for cell in cells for out in cell.get("outputs", []))


def test_the_peers(sq: ModuleType, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture) -> None:
    """Our figures are as stored. Those of peers that are not installed are skipped."""
    monkeypatch.chdir(ROOT)
    cells = cells_of("peers")
    held = run(cells)
    now, then = capsys.readouterr().out, printed(cells)
    row = re.compile(r"^(squid-lpv|slycot|dkpy) +gamma +(\S+) +gain of its loop +(\S+) .*?(WRONG)?$", re.M)
    ours = [
        [list(map(float, found[1:3])) for found in row.findall(text) if found[0] == "squid-lpv"]
        for text in (now, then)
    ]
    assert len(ours[0]) == 4 and ours[0] == [pytest.approx(pair, rel=GOLDEN) for pair in ours[1]]
    assert [found[0] for found in row.findall(then) if found[3]] == ["slycot", "slycot"]
    assert {found[0] for found in row.findall(then)} == {"squid-lpv", "slycot", "dkpy"}
    assert now.count("InfeasibleError: ") == then.count("InfeasibleError: ") > 0 and "not proved" in now
    for name, least in {"oscillator": 0.5 / (0.1 * 0.99**0.5), "known": 0.65**0.5}.items():
        gamma, gain = held[name]["squid-lpv"]
        assert least * (1.0 - GRID) <= gain <= gamma
