# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Every example runs as it stands; each judges its own numbers."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from ..patience import HANGING

ROOT = Path(__file__).parents[2]
EXAMPLES = sorted((ROOT / 'examples').glob('*.py'))
COMPILED = {'stack'}  # some hundred times slower as plain source


@pytest.mark.parametrize('path', EXAMPLES, ids=lambda path: path.stem)
def test_the_example_runs_and_its_numbers_hold(path):
    compiled = os.environ.get('RIGID_BODY_SIM_COMPILE', '1') if path.stem in COMPILED else '0'
    result = subprocess.run(
        [sys.executable, str(path)],
        cwd=ROOT,
        env=os.environ | {'PYTHONPATH': str(ROOT), 'RIGID_BODY_SIM_COMPILE': compiled},
        capture_output=True,
        text=True,
        timeout=HANGING,
        check=False,
    )
    assert result.returncode == 0, result.stdout + result.stderr
    assert result.stdout.strip(), 'an example shows something'
