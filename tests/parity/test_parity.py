"""The quick scenes of the parity suite; ``make accuracy`` renders all of them."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.parity.cases import CASES
from tests.parity.runner import judge, render

QUICK = [name for name, case in CASES.items() if case.quick]


@pytest.fixture(scope="module")
def rendered(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the quick scenes, rendered by both engines in one process of Blender."""
    out = tmp_path_factory.mktemp("parity")
    render(QUICK, out)
    return out


@pytest.mark.blender
@pytest.mark.parametrize("name", QUICK)
def test_photon_map_shows_what_cycles_shows(rendered: Path, name: str) -> None:
    verdict = judge(rendered, name)
    assert verdict.state == "pass", f"{CASES[name].says}: {verdict}"


def test_there_are_enough_scenes() -> None:
    assert len(CASES) >= 32
    assert len(QUICK) >= 8
