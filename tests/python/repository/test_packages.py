"""Every crate as cargo would publish it."""

from __future__ import annotations

import subprocess

import pytest
from fly.stages import ROOT

pytestmark = pytest.mark.night


def test_cargo_packages_every_crate() -> None:
    """The sources of a crate are in its folder, and all its dependencies can be published, too."""
    words = ["cargo", "package", "--workspace", "--no-verify", "--allow-dirty"]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
