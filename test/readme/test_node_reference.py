# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""docs/node.md has the topics, services and parameters of the node, docs/viewers.md its views."""

import importlib.util
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


def test_the_page_is_what_the_code_says():
    pytest.importorskip('rclpy')
    spec = importlib.util.spec_from_file_location(
        'node_reference', ROOT / 'tools' / 'node_reference.py'
    )
    tool = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(tool)
    assert tool.page() == tool.PAGE.read_text(), 'run `python tools/node_reference.py`'
    assert tool.page_of_views() == tool.VIEWERS.read_text()
