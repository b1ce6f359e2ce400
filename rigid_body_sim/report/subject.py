# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What a report is of, in words: problems with exact answers, or a scene of the user's.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

Row = Mapping[str, Any]


def subject(made: Row) -> str:
    """Say in a sentence what was measured."""
    if made.get('scene'):
        return (
            f'What each method costs and how wrong it is on the scene {made["scene"]}, against '
            'the finest run that was found, which stands for the exact motion.'
        )
    return 'What each method costs and how wrong it is, on problems whose exact answers are known.'


def answer(problem: Row) -> str:
    """Say against what a problem is measured."""
    known = 'Reference' if 'reference_error' in problem else 'Exact answer'
    return f'{known}: {problem["reference"]}'
