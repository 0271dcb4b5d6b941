"""Each test has a tier: needed for a change, or run only every night."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest
from fly.stages import ROOT

pytestmark = pytest.mark.change

SUPPORT = ROOT / "tests" / "python" / "support"
CONFTEST = f"""
import sys
sys.path.insert(0, {str(SUPPORT)!r})
from tiers import check
def pytest_collection_modifyitems(items):
    check(items)
"""
IGNORED = re.compile(r'#\[ignore(?! = "night: )[^\]]*\]')


def collected(folder: Path, test: str) -> subprocess.CompletedProcess:
    """Let pytest collect a file with one test."""
    (folder / "conftest.py").write_text(CONFTEST, encoding="utf-8")
    (folder / "test_one.py").write_text(test, encoding="utf-8")
    words = [sys.executable, "-m", "pytest", "-c", ROOT / "tests" / "pytest.ini", "--rootdir", folder]
    words += ["--collect-only", "-m", "not night", folder]
    return subprocess.run(list(map(str, words)), capture_output=True, text=True, check=False)


def test_a_test_of_no_tier_is_refused(tmp_path: Path) -> None:
    test = "import pytest\n{}\ndef test_it(): pass\n"
    refused = collected(tmp_path, test.format(""))
    assert refused.returncode == pytest.ExitCode.USAGE_ERROR
    assert "test_one.py::test_it" in refused.stderr
    for tier, code in (("change", pytest.ExitCode.OK), ("night", pytest.ExitCode.NO_TESTS_COLLECTED)):
        assert collected(tmp_path, test.format(f"@pytest.mark.{tier}")).returncode == code


def test_what_rust_ignores_is_run_at_night() -> None:
    """`cargo test -- --include-ignored` is the command of `run.py test --all`."""
    sources = [path for path in ROOT.glob("**/*.rs") if not {"target", "build"} & set(path.parts)]
    ignored = {path: IGNORED.findall(path.read_text(encoding="utf-8")) for path in sources}
    assert not {path: found for path, found in ignored.items() if found}
