"""The list of hard cases names every test of this folder, and only those."""

from __future__ import annotations

import ast
from pathlib import Path

from photon_map.tests.stability.rows import ROWS


def test_every_hard_case_has_tests_and_every_test_a_case():
    written = {
        node.name.removeprefix("test_")
        for file in Path(__file__).parent.glob("test_*.py")
        if file.name != "test_rows.py"
        for node in ast.parse(file.read_text("utf-8")).body
        if isinstance(node, ast.FunctionDef) and node.name.startswith("test_")
    }
    assert {name for row in ROWS for name in row.tests} == written
