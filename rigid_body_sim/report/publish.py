# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Everything a folder of results holds: numbers first, then pictures and the page."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rigid_body_sim.report import results


def publish(report: Mapping[str, Any], folder: Path) -> None:
    """Write the results into a folder; called again after each problem, with one problem more."""
    results.write(report, folder)
