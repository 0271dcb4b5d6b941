"""Pages of the report in headless Chromium: no script fails, nothing is cut off, no figure is empty."""

from __future__ import annotations

import html
import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from conftest import FAILED, SQUID, Run, reported
from fly.stages import ROOT

CHROMIUM = shutil.which("chromium")
PROBE = (ROOT / "tests" / "python" / "support" / "probe.js").read_text(encoding="utf-8")
CATCH = "window.problems = []; addEventListener('error', event => problems.push(String(event.message)));"
VEHICLES = sorted(path.parent for path in (ROOT / "vehicles").glob("*/design.toml"))
NARROW, WIDE = 420, 1400
FLAGS = (
    "--headless --no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking "
    "--disable-component-update --disable-sync --hide-scrollbars --virtual-time-budget=10000"
)

pytestmark = pytest.mark.night


def look(page: str, folder: Path, width: int, *flags: str) -> dict:
    """Return the findings of the probe in a window of this width."""
    probed = page.replace("<head>", f"<head><script>{CATCH}</script>", 1)
    probed = probed.replace("</body>", f"<script>/*<![CDATA[*/{PROBE}/*]]>*/</script></body>", 1)
    path = folder / "page.html"
    # A frame is used because a window is at least 500 pixels wide; a frame inherits the colour scheme of its page.
    framed = f'<iframe style="border:0;width:{width}px;height:900px" srcdoc="{html.escape(probed)}"></iframe>'
    scheme = '<meta charset="utf-8"><meta name="color-scheme" content="light dark">'
    path.write_text(f"<!DOCTYPE html>{scheme}<body>{framed}</body>", encoding="utf-8")
    assert CHROMIUM, "chromium is missing: apt-get install chromium"
    words = [CHROMIUM, *FLAGS.split(), *flags, f"--user-data-dir={folder / 'profile'}"]
    words += [f"--window-size={WIDE + 100},1000", "--dump-dom", path.as_uri()]
    done = subprocess.run(words, capture_output=True, text=True, timeout=120, check=True)
    found = re.search(r'<pre id="probe">(.*?)</pre>', done.stdout, re.DOTALL)
    assert found, done.stderr
    return json.loads(html.unescape(found[1]))


def brightness(colour: str) -> float:
    """Return the mean of red, green and blue, 0 to 255."""
    return sum(map(float, re.findall(r"[\d.]+", colour)[:3])) / 3


@pytest.mark.parametrize("vehicle", VEHICLES, ids=lambda vehicle: vehicle.name)
def test_a_page_is_whole_in_a_narrow_and_in_a_wide_window(
    run_squid: Run, vehicle: Path, tmp_path: Path
) -> None:
    """On the page of each shipped vehicle no script fails, nothing is cut off, and every chart has readable curves."""
    page = reported(run_squid, vehicle)
    assert FAILED not in page
    for width in (NARROW, WIDE):
        found = look(page, tmp_path, width)
        assert found["problems"] == []
        assert found["width"] == width
        assert found["scrollWidth"] <= width and found["over"] == []
        assert len(found["figures"]) >= 10
        for figure in found["figures"]:
            assert figure["charts"] and figure["switches"], figure["id"]
            for chart in figure["charts"]:
                assert chart["drawn"], (figure["id"], chart["label"])
                assert 0.5 * min(width, 600) < chart["width"] <= width, (figure["id"], chart["label"])
        shown = [chart["shown"] for figure in found["figures"] for chart in figure["charts"]]
        assert sum(bool(re.search(r"\d", words)) for words in shown) > 0.9 * len(shown), (
            "values under the pointer"
        )
        assert brightness(found["paper"]) > 200 > 100 > brightness(found["ink"])


def test_a_wide_table_scrolls_within_itself(run_squid: Run, quick_vehicle: Path, tmp_path: Path) -> None:
    """The page has four designs side by side, with names of realistic length."""
    vehicle = Path(shutil.copytree(quick_vehicle, tmp_path / "vehicle"))
    names = [f"a-design-of-{person}" for person in ("mine", "theirs", "yours")]
    for name in names:
        shutil.copy(vehicle / "design.toml", vehicle / f"{name}.toml")
    asked = [word for name in names for word in ("--beside", name)]
    done = run_squid("report", vehicle, "--out", tmp_path / "out", *asked)
    assert done.returncode == 0, done.stderr
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert all(f">{name}<" in page for name in names)
    for width in (NARROW, WIDE):
        found = look(page, tmp_path, width)
        assert found["problems"] == []
        assert found["width"] == width
        assert found["scrollWidth"] <= width and found["over"] == []


def test_a_page_is_dark_where_the_system_is(run_squid: Run, tmp_path: Path) -> None:
    dark = look(reported(run_squid, SQUID), tmp_path, WIDE, "--force-dark-mode")
    assert dark["problems"] == []
    assert brightness(dark["paper"]) < 60 < 180 < brightness(dark["ink"])


def test_the_probe_sees_what_is_wrong(run_squid: Run, tmp_path: Path) -> None:
    """The probe detects a failing script, a box that is too wide, and missing curves."""
    page = reported(run_squid, SQUID)
    spoiled = page.replace("</h1>", "</h1><script>missing();</script><div style='width:900px'>wide</div>", 1)
    spoiled = re.sub(r' points="[^"]*"', ' points=""', spoiled)
    found = look(spoiled, tmp_path, NARROW)
    assert any("missing" in problem for problem in found["problems"])
    assert found["scrollWidth"] > NARROW and any("wide" in words for words in found["over"])
    assert all(
        figure["id"] == "fig7-mu-bounds"
        for figure in found["figures"]
        if any(c["drawn"] for c in figure["charts"])
    )
