"""Hands what a test has measured on to the report of the run."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest

from photon_map.tests.stability import support


@pytest.fixture(autouse=True)
def noted(record_property: Callable[[str, object], None]) -> Iterator[None]:
    """The largest deviation goes into the JUnit file of each test that noted one."""
    support.NOTED.clear()
    yield
    if support.NOTED:
        record_property("deviation", f"{max(support.NOTED):.2e}")
