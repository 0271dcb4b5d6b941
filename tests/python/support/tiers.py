"""Tiers of the tests: needed for a change, or run every night in addition."""

from __future__ import annotations

from collections.abc import Iterable

import pytest

TIERS = ("change", "night")
"""The markers of the tiers, which tests/pytest.ini describes."""


def check(items: Iterable[pytest.Item]) -> None:
    """Raise an error that names the tests without a tier."""
    without = [item.nodeid for item in items if not any(item.get_closest_marker(tier) for tier in TIERS)]
    if without:
        raise pytest.UsageError(
            f"in no tier: {', '.join(without)}; mark the file, `pytestmark = pytest.mark.change`, or the test."
        )
