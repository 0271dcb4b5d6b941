"""The front page is short, links between pages resolve, and the hosted workflow runs what it says."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest
from fly.stages import ROOT

pytestmark = pytest.mark.change

LINK = re.compile(r"(?<!`)\[[^]]*\]\(([^)\s]+)\)")
SCREEN_AND_A_HALF = 60


def pages() -> list[Path]:
    listed = subprocess.run(["git", "ls-files", "*.md"], cwd=ROOT, capture_output=True, text=True, check=True)
    return [ROOT / name for name in listed.stdout.splitlines()]


def anchors(page: Path) -> set[str]:
    """Return the anchors of a page's headings, as hosts of repositories make them."""
    headings = re.findall(r"^#+ (.*)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("page", pages(), ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_somewhere(page: Path) -> None:
    text = re.sub(r"```.*?```|`[^`\n]*`", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    for link in LINK.findall(text):
        if "://" in link:
            continue
        name, _, anchor = link.partition("#")
        to = (page.parent / name).resolve() if name else page
        assert to.exists(), link
        assert not anchor or anchor in anchors(to), link


def test_the_front_page_is_short() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert len(text.splitlines()) <= SCREEN_AND_A_HALF
    assert len(re.findall(r"!\[", text)) == 1


def test_the_hosted_workflow_runs_every_test_at_night_alone() -> None:
    text = (ROOT / ".github" / "workflows" / "ci.yml").read_text(encoding="utf-8")
    runs = re.findall(r"if: github\.event_name (..) 'schedule'\n +run: (.*)\n", text)
    assert runs == [("!=", ".ci/run"), ("==", ".ci/run --all")]
    assert all(f"\n  {event}:" in text for event in ("push", "pull_request", "schedule"))
