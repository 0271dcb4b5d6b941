"""`squid report --beside`: designs of one vehicle in one table; what is won and lost, and what is missed."""

from __future__ import annotations

import json
import re
import shutil
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import NamedTuple

import pytest
from conftest import REMUS100, Run, design, messages, named, refusal
from syrupy.assertion import SnapshotAssertion

pytestmark = pytest.mark.change

XHTML = "{http://www.w3.org/1999/xhtml}"
OPPOSITE = {"won": "lost", "drawn": "drawn", "lost": "won", "": ""}


class Beside(NamedTuple):
    """A vehicle with two designs, the folder of the report on both, and the output of the command."""

    vehicle: Path
    folder: Path
    said: str


@pytest.fixture(scope="module")
def beside(run_squid: Run, quick_vehicle: Path, tmp_path_factory: pytest.TempPathFactory) -> Beside:
    """Return the report on the quick vehicle compared with a softer design, which misses its requirements."""
    vehicle = shutil.copytree(quick_vehicle, tmp_path_factory.mktemp("beside") / "vehicle")
    text = (vehicle / "design.toml").read_text(encoding="utf-8")
    assert "bandwidth = 0.46" in text and "[require]\n" in text
    softer = text.replace("bandwidth = 0.46", "bandwidth = 0.3").replace(
        "beyond_recovery = 20.0", "beyond_recovery = 60.0"
    )
    softer += "phase_margin = 80.0  # deg\n"
    (vehicle / "soft.toml").write_text(softer, encoding="utf-8")
    folder = vehicle.parent / "out"
    design(run_squid, vehicle, folder / "beside" / "soft", "--design", "soft")
    before = (folder / "beside" / "soft" / "controller.json").stat().st_mtime_ns
    said = report(run_squid, vehicle, folder, "--beside", "soft")
    assert (folder / "beside" / "soft" / "controller.json").stat().st_mtime_ns == before, "designed again"
    return Beside(vehicle, folder, said)


def report(run_squid: Run, vehicle: Path, folder: Path, *options: str) -> str:
    """Return the output of the command that writes a report."""
    done = run_squid("report", vehicle, "--out", folder, *options)
    assert done.returncode == 0, done.stderr
    return done.stdout


def computed(folder: Path) -> int:
    """Return the time at which the report was computed."""
    return (folder / "report.json").stat().st_mtime_ns


def words(element: ET.Element) -> str:
    return " ".join(" ".join(element.itertext()).split())


def table(folder: Path) -> list[list[ET.Element]]:
    """Return the cells of the table of the section; none if there is no such section."""
    page = ET.fromstring((folder / "report.html").read_text(encoding="utf-8"))
    found = [s for s in page.iter(f"{XHTML}section") if s.attrib["id"] == "peers"]
    return [list(row) for section in found for row in section.iter(f"{XHTML}tr")]


def cells(folder: Path) -> list[list[str]]:
    """Return the text of the cells."""
    return [[words(cell) for cell in row] for row in table(folder)]


def test_each_design_has_a_column(
    beside: Beside, run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """Each design has its own sizes, proofs and figures, whichever is the main one; one wins where the other loses."""
    head, *rows = cells(beside.folder)
    assert "\n".join([", ".join(head), *(row[0] for row in rows)]) == snapshot
    against = head.index("against soft")
    folders = {"design": beside.folder, "soft": beside.folder / "beside" / "soft"}
    for column, name in enumerate(("design", "soft"), start=2):
        figures = json.loads((folders[name] / "design.json").read_text(encoding="utf-8"))
        lft = json.loads((folders[name] / "controller.json").read_text(encoding="utf-8"))["lft"]
        found = {row[0]: row[column] for row in rows}
        sizes, proved, sampled = (row[column] for row in rows[:3])
        assert sizes == f"{len(lft['A'])}, {len(lft['Dtt'])}"
        assert float(proved) == pytest.approx(figures["gamma_bound"], abs=1e-4)
        assert float(sampled) == pytest.approx(figures["gamma_bound_sampled"], abs=1e-4)
        for row in figures["verdict"]["rows"]:
            assert float(found[row["what"]].split()[0]) == pytest.approx(
                row["achieved"]["value"], rel=2e-2, abs=1e-3
            )
    # The roles swapped, with the other design not yet designed.
    swapped = tmp_path / "out"
    design(run_squid, beside.vehicle, swapped, "--design", "soft")
    said = report(run_squid, beside.vehicle, swapped, "--design", "soft", "--beside", "design")
    head, *others = cells(swapped)
    assert head[2:4] == ["soft", "design"] and head[against] == "against design"
    assert (swapped / "beside" / "design" / "certificate.json").is_file()
    for row, other in zip(rows, others, strict=True):
        assert other[0] == row[0]
        assert [re.sub(r" \(.*\)", "", cell) for cell in other[3:1:-1]] == [
            re.sub(r" \(.*\)", "", cell) for cell in row[2:4]
        ]
        assert other[against] == OPPOSITE[row[against]]
    assert {"won", "lost"} <= {row[against] for row in rows}
    for text, of in ((beside.said, rows), (said, others)):
        won, drawn, lost = (
            sum(row[against] == outcome for row in of) for outcome in ("won", "drawn", "lost")
        )
        assert re.search(rf"\b{won}\D+{drawn}\D+{lost}\b", text)


def test_what_a_design_misses_is_marked(beside: Beside, snapshot: SnapshotAssertion) -> None:
    """A design is marked by the requirements of its own file; a hull that a moment capsizes is marked, too."""
    marked = [
        (words(row[0]), place, words(cell))
        for row in table(beside.folder)
        for place, cell in enumerate(row)
        if cell.attrib.get("class") == "missed" or "MISSED" in words(cell)
    ]
    assert [place for _, place, _ in marked] == [3, 3]
    assert "\n".join(what for what, _, _ in marked) == snapshot
    assert re.fullmatch(r"\d+\.\d deg \(> 80 deg\) MISSED", marked[0][2])
    missed = next(row for row in table(beside.folder) if words(row[0]) == "phase margin")
    assert words(missed[1]) == "> 45 deg" and missed[3].attrib["class"] == "missed"


def copied(folder: Path, to: Path) -> Path:
    """Return a copy of a folder of designs, without the mark of their vehicle."""
    return shutil.copytree(folder, to, ignore=shutil.ignore_patterns(".squid-vehicle"))


def test_what_is_not_proved_is_said(beside: Beside, run_squid: Run, tmp_path: Path) -> None:
    """Certificates of another controller prove nothing here; they are verified again for the page."""
    folder = copied(beside.folder, tmp_path / "out")
    for name in ("certificate.json", "sampled_certificate.json"):
        shutil.copy(folder / name, folder / "beside" / "soft")
    report(run_squid, beside.vehicle, folder, "--beside", "soft")
    assert computed(folder) > computed(beside.folder)
    (_, *before), (_, *after) = cells(beside.folder), cells(folder)
    # The gain, and that of the sampled loop.
    assert [place for place, row in enumerate(after) if row != before[place]] == [1, 2]
    assert after[1][3] == after[2][3] == "NO"


def test_a_changed_design_is_computed_again(
    beside: Beside, run_squid: Run, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """And what did not change is shown as it was; without --beside there is no such column."""
    vehicle = shutil.copytree(beside.vehicle, tmp_path / "vehicle")
    folder = copied(beside.folder, tmp_path / "out")
    before, made = cells(folder), computed(folder)
    report(run_squid, vehicle, folder, "--beside", "soft")
    assert computed(folder) == made
    soft = vehicle / "soft.toml"
    text = soft.read_text(encoding="utf-8").replace("phase_margin = 80.0  # deg\n", "")
    soft.write_text(text.replace("bandwidth = 0.3", "bandwidth = 0.35") + "\n", encoding="utf-8")
    said = report(run_squid, vehicle, folder, "--beside", "soft")
    assert computed(folder) > made
    (note,) = (line for line in said.splitlines() if line.startswith("again"))
    assert named(note, TMP=tmp_path) == snapshot
    after, made = cells(folder), computed(folder)
    assert [row[2] for row in after] == [row[2] for row in before]
    differ = {row[0] for row, other in zip(after, before, strict=True) if row[3] != other[3]}
    assert {after[2][0], "phase margin"} <= differ and any("ITAE" in what for what in differ)
    assert not any("MISSED" in cell for row in after for cell in row)
    report(run_squid, vehicle, folder, "--beside", "soft")
    assert computed(folder) == made
    report(run_squid, vehicle, folder)
    assert computed(folder) > made
    assert "soft" not in cells(folder)[0]


@pytest.mark.parametrize(
    ("names", "key", "code"),
    [
        (["nosuch"], "no_design", 1),
        (["soft", "soft"], "argument", 64),
        (["design"], "argument", 64),
        (["soft", "vehicle"], "usage", 64),
        (["deep"], "not_beside", 1),
    ],
)
def test_what_cannot_stand_beside_is_refused(
    beside: Beside,
    run_squid: Run,
    tmp_path: Path,
    names: list[str],
    key: str,
    code: int,
    snapshot: SnapshotAssertion,
) -> None:
    """A design that cannot be compared is refused with one message, and nothing is designed or written."""
    vehicle = shutil.copytree(beside.vehicle, tmp_path / "vehicle")
    text = (vehicle / "design.toml").read_text(encoding="utf-8")
    (vehicle / "deep.toml").write_text(text.replace("depth = 50.0", "depth = 40.0"), encoding="utf-8")
    words = [word for name in names for word in ("--beside", name)]
    done = run_squid("report", vehicle, "--out", tmp_path / "out", *words, "--json")
    refusal(done, key, code)
    assert messages(done, TMP=tmp_path) == snapshot
    assert not (tmp_path / "out").exists()


def test_a_design_on_depth_flies_another_course(run_squid: Run, tmp_path: Path) -> None:
    for words in (("--design", "pitch", "--beside", "design"), ("--beside", "pitch", "--axis", "depth")):
        done = run_squid("report", REMUS100, *words, "--out", tmp_path / "out")
        assert done.returncode == 1, done.stderr
    assert not (tmp_path / "out").exists()
