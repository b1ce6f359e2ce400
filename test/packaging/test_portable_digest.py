# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Final states that were made on one machine come out bit for bit on this one."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SAVED = ROOT / 'tools' / 'portable_digest.txt'


def test_final_states_are_those_of_another_machine_bit_for_bit():
    command = [sys.executable, 'tools/digest.py', '--portable', '--against', str(SAVED)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    lines = len(SAVED.read_text().splitlines()) - 1
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.strip() == f'{lines} lines agree, 0 differ, 0 stand in one alone'
