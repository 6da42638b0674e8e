"""What all tests share: markers by folder, a seeded generator, floating-point errors raised."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import hypothesis
import numpy as np
import pytest

HERE = Path(__file__).parent

# The same examples in every run: a red build can be repeated.
hypothesis.settings.register_profile("photon_map", derandomize=True, deadline=None)
hypothesis.settings.load_profile("photon_map")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if {"addon", "blender"} & set(item.path.relative_to(HERE).parts[:-1]):
            item.add_marker(pytest.mark.blender)


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(20240229)


@pytest.fixture(autouse=True)
def _floating_point_errors() -> Iterator[None]:
    """Division by zero, overflow and invalid operations in NumPy are errors in tests."""
    with np.errstate(divide="raise", over="raise", invalid="raise"):
        yield
