# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Who asks for steps is told of them: each, of many a thousand.
"""

import pytest

from rigid_body_sim.ros import stepping
from rigid_body_sim.ros.requests import Request
from rigid_body_sim.ros.stepping import MOST_SAID, Steps, StepsAsked


@pytest.mark.parametrize('count', [1, 7, 999, 1000, 1001, 1999, 2500, 123457])
@pytest.mark.parametrize('longest', [1, 10**9])  # steps at a time, as in lock-step and without it
def test_of_many_steps_a_thousand_are_told_evenly(monkeypatch, count, longest):
    monkeypatch.setattr(stepping, 'TELL', 10**18)
    told = []
    steps = Steps(Request('steps', StepsAsked(count, lambda *both: told.append(both))))
    while steps.left:
        steps.note(min(longest, steps.stretch))
    done = [number for number, _ in told]
    assert len(told) == min(count, MOST_SAID)
    assert all(number + left == count for number, left in told)
    assert done[-1] == count
    gaps = {after - before for before, after in zip([0, *done], done, strict=False)}
    assert max(gaps) - min(gaps) <= 1
