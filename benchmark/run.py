# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
`make bench-all`: every figure that a test must not judge: step costs, start-up, real-time
behaviour of the node, and the largest steps.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).parent
SCRIPTS = ('step_cost.py', 'closed_loop.py', 'start_up.py', 'real_time.py', 'stability_limits.py')


def main() -> int:
    """Run the benchmarks one after the other; give the worst exit code."""
    codes = []
    for script in SCRIPTS:
        print(f'--- {script}', flush=True)
        codes.append(subprocess.run([sys.executable, str(HERE / script)], check=False).returncode)
        print()
    return max(codes)


if __name__ == '__main__':
    sys.exit(main())
