"""The tiers of the tests: what a change needs, and what is run every night besides."""

from __future__ import annotations

from collections.abc import Iterable

import pytest

TIERS = ("change", "night")
"""The markers of the tiers, which tests/pytest.ini describes."""


def check(items: Iterable[pytest.Item]) -> None:
    """Raise an error that names the tests of no tier."""
    without = [item.nodeid for item in items if not any(item.get_closest_marker(tier) for tier in TIERS)]
    if without:
        raise pytest.UsageError(
            f"in no tier: {', '.join(without)}; mark the file, `pytestmark = pytest.mark.change`, or the test."
        )
