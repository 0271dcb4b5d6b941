"""The notebook of the documentation runs, and says what it did when it was written."""

from __future__ import annotations

import json
from types import ModuleType

import pytest
from fly.stages import ROOT

TOUR = ROOT / "docs" / "tour.ipynb"
GOLDEN = 1e-3
"""Relative: processors round differently, and the solver's iterations amplify this."""


def test_the_tour(sq: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MPLBACKEND", "agg")
    monkeypatch.chdir(ROOT)
    cells = json.loads(TOUR.read_text(encoding="utf-8"))["cells"]
    held: dict = {}
    for cell in cells:
        if cell["cell_type"] == "code":
            exec("".join(cell["source"]), held)
    design, theorem = held["design"], held["theorem"]
    assert theorem.gamma == design.gamma
    assert {row["outcome"] for row in design.verdict} == {"met", "reported"}
    frozen = json.loads(
        (ROOT / "vehicles" / "squid" / "frozen" / "controller.json").read_text(encoding="utf-8")
    )
    assert design.gamma == pytest.approx(frozen["gamma"]["bound"], rel=GOLDEN)
    assert any("image/png" in out.get("data", {}) for cell in cells for out in cell.get("outputs", []))
