# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Everything a folder of results holds: numbers first, then the page, the text, the pictures."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rigid_body_sim.report import markdown, page, pictures, results


def publish(report: Mapping[str, Any], folder: Path) -> None:
    """
    Write the results into a folder; called again after each problem, with one problem more.

    The pictures of the earlier problems are there already.
    """
    results.write(report, folder)
    page.write(report, folder)
    markdown.write(report, folder)
    pictures.write({**report, 'problems': report['problems'][-1:]}, folder)
