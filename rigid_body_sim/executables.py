# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Entry points of the executables that pip and colcon install; nothing else imports this.

Until a verb listens to signals Ctrl-C ends the process at once: told to Python before anything
else is imported, or there would be a traceback out of the imports.
"""

import signal

signal.signal(signal.SIGINT, signal.SIG_DFL)

from rigid_body_sim.__main__ import (  # noqa: E402
    bag,
    command,
    export,
    inspect,
    inverse,
    list_what_there_is,
    replay,
    report,
    sim_node,
    simulate,
    sweep,
    view,
    warm_up,
    wrench_pub,
)

__all__ = [
    'bag',
    'command',
    'export',
    'inspect',
    'inverse',
    'list_what_there_is',
    'replay',
    'report',
    'sim_node',
    'simulate',
    'sweep',
    'view',
    'warm_up',
    'wrench_pub',
]
