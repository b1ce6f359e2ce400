# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
`python -m rigid_body_sim.testing.child PARENT sim_node …`: the node of a test.

It ends as by SIGINT when the process PARENT is gone, so that a test run that was killed leaves
nothing behind.
"""

from __future__ import annotations

import os
import runpy
import signal
import sys
import threading
import time

LOOK = 1.0  # [s] between looks whether the parent is there


def _watch(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(LOOK)
    os.kill(os.getpid(), signal.SIGINT)


def main() -> None:
    """Become the verb that stands behind the parent's number."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # until the verb listens
    parent = int(sys.argv.pop(1))
    threading.Thread(target=_watch, args=(parent,), name='parent_watch', daemon=True).start()
    runpy.run_module('rigid_body_sim', run_name='__main__', alter_sys=True)


if __name__ == '__main__':
    main()
