"""The report: one self-contained page, every figure, the paper's claims on request; and the page in the FMUs."""

from __future__ import annotations

import hashlib
import math
import re
import shutil
import xml.etree.ElementTree as ET
import zipfile
from pathlib import Path
from typing import NamedTuple

import pytest
from conftest import FAILED, PITCHING, SQUID, Run, design, designed, masked, once, reported
from conftest import written as write
from fly import build
from fly.package import Packages
from syrupy.assertion import SnapshotAssertion

pytestmark = pytest.mark.change

XHTML = "{http://www.w3.org/1999/xhtml}"
SVG = "{http://www.w3.org/2000/svg}"
LARGEST_PAGE = 1_000_000
FIGURES = {
    "envelope-over-speed",
    "pitch-steps",
    "speed-steps",
    "beyond-limits",
    "held-responses",
    "margins-over-speed",
    "noise-over-speed",
    "pitch-step-on-a-ramp",
    "fig1a-structure",
    "fig1b-structure",
    "fig2-weights",
    "loop-of-pitch",
    "loop-of-speed",
    "current",
    "noise",
    "weights-and-sensitivity",
    "fig7-mu-bounds",
    "ladder-of-gammas",
    "fig3-entries-of-A",
    "fig4-frequency-responses",
}
OF_THE_DESIGN = {"pitch-steps", "speed-steps", "margins-over-speed", "noise-over-speed"}
OF_THE_PAPER = {"fig5-pitch-responses", "fig6-open-loop", "scheduled-and-switched"}
VEHICLES = {"squid": SQUID, "remus100": PITCHING}
ACTUATORS = {"squid": 3, "remus100": 2}
ALL = ("--paper", "--beside", "proved")
CLAIMS = 12
"""Of the paper."""
FINDINGS = {"confirmed", "partly confirmed", "not confirmed"}
"""Of a claim that can be judged."""


class Written(NamedTuple):
    """Name of a vehicle, folder of its report, and True if the report has the paper's sections and claims."""

    name: str
    folder: Path
    paper: bool


@pytest.fixture(params=[*ACTUATORS, "--paper"])
def written(request: pytest.FixtureRequest, run_squid: Run) -> Written:
    """Return the report on each of two vehicles, and the report on Squid with the paper's claims."""
    if request.param == "--paper":
        return Written("squid", with_the_paper(run_squid), paper=True)
    vehicle = VEHICLES[request.param]
    reported(run_squid, vehicle)
    return Written(request.param, designed(run_squid, vehicle), paper=False)


def with_the_paper(run_squid: Run) -> Path:
    """Return the folder of the report on Squid with the paper's claims and another design, made once."""

    def make(folder: Path) -> None:
        shutil.copytree(
            designed(run_squid, SQUID), folder, ignore=shutil.ignore_patterns("report*", "figures")
        )
        design(run_squid, SQUID, folder / "beside" / "proved", "--design", "proved")
        write(run_squid, folder, "report", SQUID, *ALL)

    return once([build.squid(), *sorted(SQUID.glob("*.toml"))], ["report", *ALL], make)


@pytest.fixture
def page(written: Written) -> ET.Element:
    """Return the page, which is well-formed XML."""
    return ET.fromstring((written.folder / "report.html").read_text(encoding="utf-8"))


def test_is_not_computed_again(written: Written, run_squid: Run, tmp_path: Path) -> None:
    """A second run shows the results of the first."""
    name, first, paper = written
    folder = shutil.copytree(first, tmp_path / name)
    before = (folder / "report.html").read_bytes()
    again = run_squid("report", VEHICLES[name], "--out", folder, *(ALL if paper else []))
    assert again.returncode == 0, again.stderr
    assert "Robust stability" not in again.stdout
    assert (folder / "report.html").read_bytes() == before
    # What was computed is kept in this file.
    assert (folder / "report.json").stat().st_mtime_ns == (first / "report.json").stat().st_mtime_ns


def words(element: ET.Element) -> str:
    return " ".join(" ".join(element.itertext()).split())


def test_page_needs_nothing_else(written: Written, page: ET.Element) -> None:
    """Every reference stays within the page, and neither style nor script fetches anything."""
    for element in page.iter():
        tag = element.tag.removeprefix(XHTML)
        assert tag not in {"link", "iframe", "object", "embed", "img", "image", "base"}, tag
        for name, value in element.attrib.items():
            assert not name.startswith("on"), f"{tag} {name}"
            if name.rsplit("}", 1)[-1] in {"href", "src", "data", "action", "srcset", "poster"}:
                assert value.startswith("#"), f"{tag} {name}={value}"
            assert "url(" not in value, f"{tag} {name}={value}"
        if tag == "script":
            assert not element.attrib
            assert not re.search(r"fetch|import|XMLHttp|https?:(?!//www.w3.org/2000/svg)", element.text or "")
        if tag == "style":
            assert "url(" not in words(element)
            assert "@import" not in words(element)
    assert (written.folder / "report.html").stat().st_size < LARGEST_PAGE


def test_links_lead_somewhere(page: ET.Element) -> None:
    anchors = [element.attrib["id"] for element in page.iter() if "id" in element.attrib]
    assert len(anchors) == len(set(anchors))
    links = [link.attrib["href"][1:] for link in page.iter(f"{XHTML}a")]
    assert len(links) == len(list(page.iter(f"{XHTML}section")))
    assert set(links) <= set(anchors)


def test_every_figure_is_there(written: Written, page: ET.Element) -> None:
    """Every figure is in the page and a file of its own, with curves that have points and units on the axes."""
    name, folder, paper = written
    figures = {figure.attrib["id"]: figure for figure in page.iter(f"{XHTML}figure")}
    assert set(figures) == (FIGURES | OF_THE_PAPER if paper else FIGURES)
    assert not failed(page)
    for key, figure in figures.items():
        assert figure.find(f"{XHTML}figcaption") is not None
        if figure.attrib.get("class") == "diagram":
            assert re.search(r"\d+ states", words(figure))
            continue
        file = ET.parse(folder / "figures" / f"{key}.svg").getroot()
        assert file.tag == f"{SVG}svg"
        for curves in (figure.iter(f"{XHTML}polyline"), file.iter(f"{SVG}polyline")):
            points = [curve.attrib["points"].split() for curve in curves]
            assert points, key
            assert not re.search("nan|inf", " ".join(map(" ".join, points)), re.IGNORECASE)
        charts = [chart for chart in figure.iter(f"{XHTML}svg") if "viewBox" in chart.attrib]
        for chart in charts:
            labels = [words(text) for text in chart.iter(f"{XHTML}text")]
            assert any(re.search(r"\((s|m/s|rad/s|deg)\)$", label) for label in labels), (key, labels)
    for steps in ("pitch-steps", "speed-steps", "current"):
        titles = [words(chart) for chart in figures[steps].iter(f"{XHTML}svg") if "viewBox" in chart.attrib]
        commands = [title for title in titles if ": command (" in title]
        assert len(commands) == ACTUATORS[name] == len(titles) - 2
    if paper:
        fig5 = [c for c in figures["fig5-pitch-responses"].iter(f"{XHTML}svg") if "viewBox" in c.attrib]
        assert len(fig5) == 6, "impulse and step for three bandwidths"
        for chart in fig5:
            assert len(list(chart.iter(f"{XHTML}polyline"))) == 6, "six speeds"


def test_the_page_says_what_it_is_made_from(written: Written, page: ET.Element) -> None:
    """Version, date and hashes are below the heading, and at the foot of each printed page."""
    name = written.name
    origin = next(words(p) for p in page.iter(f"{XHTML}p") if p.attrib.get("class") == "origin")
    for file in ("vehicle.toml", "design.toml"):
        content = (VEHICLES[name] / file).read_bytes()
        assert hashlib.sha256(content).hexdigest() in origin
    assert re.search(r"^squid \d+\.\d+\.\d+; .*; files of \d{4}-\d\d-\d\d$", origin)
    assert origin in "".join(words(style) for style in page.iter(f"{XHTML}style"))


def test_claims_are_there_if_asked_and_come_last(
    written: Written, page: ET.Element, snapshot: SnapshotAssertion
) -> None:
    """Without --paper no vehicle has sections or claims of the paper, not even Squid; with it all are present."""
    sections = [section.attrib["id"] for section in page.iter(f"{XHTML}section")]
    assert sections[:3] == ["verdict", "steps", "flown"]
    own = ["tuning", "open-loop", "difficulty", "switching", "claims"]
    said = (written.folder / "report.txt").read_text(encoding="utf-8")
    if written.paper:
        assert sections[-5:] == own
        claims = [words(next(claim.iter(f"{XHTML}p"))) for claim in claims_of(page)]
        assert len(claims) == CLAIMS and "\n".join(claims) == snapshot
        told = " ".join(said.split())
        assert all(claim.removeprefix("The paper: ") in told for claim in claims)
    else:
        assert not set(own) & set(sections)
        assert not claims_of(page)
        assert "The paper" not in words(page) and "paper claims" not in said


def failed(page: ET.Element) -> list[str]:
    """Return the reasons for which sections could not be computed."""
    return [words(d) for d in page.iter(f"{XHTML}div") if d.attrib.get("class") == FAILED]


def claims_of(page: ET.Element) -> list[ET.Element]:
    """Return the claims, each with its judgement."""
    return [d for d in page.iter(f"{XHTML}div") if d.attrib.get("class", "").startswith("boxed")]


def page_with_the_paper(run_squid: Run) -> ET.Element:
    """Return the page with the paper's claims."""
    return ET.fromstring((with_the_paper(run_squid) / "report.html").read_text(encoding="utf-8"))


def test_every_claim_has_finding_criterion_and_numbers(run_squid: Run) -> None:
    for judged in claims_of(page_with_the_paper(run_squid)):
        claim, found, criterion = [words(p) for p in judged.iter(f"{XHTML}p")]
        assert claim and criterion
        finding = re.search(r": (.*?)\.", found)
        assert finding and finding[1] in FINDINGS
        assert re.search(r"\d", found), found


def test_a_surrogate_is_called_one(written: Written, page: ET.Element) -> None:
    """Heading, warning, captions and claims of Squid call it a surrogate; REMUS 100 is published."""
    surrogate = written.name == "squid"
    assert ("SURROGATE" in words(page)) == surrogate
    named = [words(c) for c in page.iter(f"{XHTML}strong")] + [words(c) for c in page.iter(f"{XHTML}h1")]
    assert all(("surrogate" in text) == surrogate for text in named)


def test_the_claim_on_the_order_follows_from_the_table(run_squid: Run) -> None:
    """The finding must be the one that the criterion gives for the residuals in the table."""
    page = page_with_the_paper(run_squid)
    tables = [
        [[words(cell) for cell in row] for row in table.iter(f"{XHTML}tr")]
        for table in page.iter(f"{XHTML}table")
    ]
    residuals = next(table for table in tables if table[0][0] == "order")
    error = {row[0]: float(row[2]) for row in residuals[1:]}
    judged = next(claim for claim in claims_of(page) if "(Fig. 4)" in words(claim))
    found = next(words(s) for s in judged.iter(f"{XHTML}strong"))
    ratio = error["1"] / error["2"]
    expected = "confirmed" if ratio >= 2 else "partly confirmed" if ratio > 1 else "not confirmed"
    assert found.endswith(f": {expected}.")


def rows_of(page: ET.Element, section: str) -> list[list[str]]:
    """Return the cells of the table of a section."""
    found = next(s for s in page.iter(f"{XHTML}section") if s.attrib["id"] == section)
    return [[words(cell) for cell in row] for row in found.iter(f"{XHTML}tr")]


def test_the_loop_as_it_flies_has_all_its_figures(page: ET.Element, snapshot: SnapshotAssertion) -> None:
    head, *rows = rows_of(page, "flown")
    assert len(head) == 8
    assert head[-1] == "worst of 51"
    assert masked("\n".join(row[0] for row in rows)) == snapshot
    assert all(cell != "unknown" for row in rows for cell in row)


def test_the_loop_comes_back_from_its_limits(written: Written, page: ET.Element) -> None:
    """The vehicle returns within 10 s from a saturated state; without anti-windup saturation lasts longer."""

    def settled(row: list[str]) -> float:
        return math.inf if row[6] in {"never", "-"} else float(row[6])

    _, *rows = rows_of(page, "limits")
    assert [row[3] for row in rows] == 3 * ["yes", "no"]
    for one, other in zip(rows[::2], rows[1::2], strict=True):
        assert settled(one) <= 10.0
        assert 0.0 < float(one[5]) <= float(other[5])
    if written.name == "remus100":
        assert float(rows[0][7]) < 2.0, "overshoot after the step at the lowest speed"
        assert all(float(one[7]) <= float(other[7]) for one, other in zip(rows[::2], rows[1::2], strict=True))


def test_the_comparison_counts_what_is_lost(page: ET.Element) -> None:
    """The PID respects the limits of its tuning, and the score is that of the rows."""
    head, *rows = rows_of(page, "peers")
    assert head[2] == "design"
    pid, against = head.index("PID"), head.index("against PID")
    limited = [row for row in rows if row[0].startswith(("peak of |S|", "commands under noise"))]
    assert len(limited) == 6
    # Both are rounded to 0.01.
    assert all(float(row[pid]) <= float(row[2]) + 0.011 for row in limited)
    outcomes = [row[against] for row in rows if row[against]]
    assert set(outcomes) <= {"won", "drawn", "lost"}
    won, drawn, lost = (outcomes.count(one) for one in ("won", "drawn", "lost"))
    assert re.search(rf"PID [^.]*\b{won}\D+{drawn}\D+{lost}\b", words(page))


def test_a_design_beside_flies_with_the_pid(run_squid: Run) -> None:
    """All are in one table; the PID has flights, and neither proof nor verdict."""
    page = page_with_the_paper(run_squid)
    head, *rows = rows_of(page, "peers")
    laws = ["design", "proved", "PID", "blended H-infinity"]
    assert head == ["", "m/s; required", *laws, *(f"against {law}" for law in laws[1:])]
    assert len({(row[0], row[1]) for row in rows}) == len(rows)
    pid = head.index("PID")
    for name in ("proved gain", "phase margin", "ITAE"):
        own = [row for row in rows if name in row[0]]
        assert own and all((row[pid] == "-") == ("ITAE" not in name) for row in own)
        assert all(row[2] != "-" and row[3] != "-" for row in own)
    assert all(law in words(page) for law in laws)


def test_the_report_follows_the_vehicle(run_squid: Run, squid_by_errors: Path, tmp_path: Path) -> None:
    """The report uses the speeds of the design file."""
    vehicle = shutil.copytree(squid_by_errors, tmp_path / "vehicle")
    design = vehicle / "design.toml"
    text = design.read_text(encoding="utf-8")
    for old, new in [("speed_min = 0.5", "speed_min = 1.5"), ("speed_from = 0.6", "speed_from = 1.6")]:
        assert old in text
        text = text.replace(old, new)
    design.write_text(text, encoding="utf-8")
    done = run_squid("report", vehicle, "--out", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "1.80 m/s" in page
    assert "0.50 m/s" not in page


def test_a_section_that_cannot_be_computed_says_why(
    run_squid: Run, squid_by_errors: Path, tmp_path: Path, snapshot: SnapshotAssertion
) -> None:
    """A design that tracks speed only has no pitch response; everything else is present."""
    vehicle = shutil.copytree(squid_by_errors, tmp_path / "vehicle")
    design = vehicle / "design.toml"
    text = design.read_text(encoding="utf-8")
    first, second = text.index("[[track]]"), text.rindex("[[track]]")
    design.write_text(text[:first] + text[second:], encoding="utf-8")
    done = run_squid("report", vehicle, "--out", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert failed(ET.fromstring(page)) == snapshot
    assert 'figure id="fig3-entries-of-A"' in page


def test_fmus_carry_what_the_design_found(
    packages: Packages, run_squid: Run, snapshot: SnapshotAssertion
) -> None:
    """The page is documentation/index.html, with a line on the FMU and on the command of the full report.

    The table of the verdict is that of `design.json` and of the full report, to the last digit.
    """
    whole = ET.fromstring(reported(run_squid, VEHICLES[packages.vehicle]))
    for fmu in packages.fmus:
        with zipfile.ZipFile(fmu) as archive:
            entry = archive.getinfo("documentation/index.html")
            page = ET.fromstring(archive.read(entry).decode())
        about = next(words(p) for p in page.iter(f"{XHTML}p") if words(p).startswith("This FMU"))
        assert masked(about) == snapshot
        figures = {figure.attrib["id"] for figure in page.iter(f"{XHTML}figure")}
        assert figures == OF_THE_DESIGN
        assert [s.attrib["id"] for s in page.iter(f"{XHTML}section")] == [
            "verdict",
            "steps",
            "flown",
            "theorem",
        ]
        assert "VEHICLE_DIR" in words(page)
        assert ("SURROGATE" in words(page)) == (packages.vehicle == "squid")
        assert not failed(page)
        for section in ("verdict", "flown"):
            assert rows_of(page, section) == rows_of(whole, section)
        assert entry.file_size < LARGEST_PAGE
