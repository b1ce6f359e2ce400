# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""`make bench`: what it calls slower."""

import importlib.util
import json
from pathlib import Path

ROOT = Path(__file__).parents[2]


def guard():
    spec = importlib.util.spec_from_file_location('guard', ROOT / 'benchmark' / 'guard.py')
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_beyond_one_and_a_half_times_is_slower_and_below_is_not():
    slower = guard().slower
    assert slower({'a': 1.6, 'b': 1.4}, {'a': 1.0, 'b': 1.0}) == ['a']
    assert slower({'a': 0.2}, {'a': 1.0}) == []
    assert slower({'new': 1.0}, {}) == ['new'], 'a cost that nobody accepted'


def test_every_cost_is_accepted():
    module = guard()
    accepted = json.loads(module.FIGURES.read_text(encoding='utf-8'))['ratios']
    assert set(accepted) == {
        *module.COSTS,
        module.CALL,
        module.LOOP,
        module.LOAD,
        module.CLOSE,
    }
