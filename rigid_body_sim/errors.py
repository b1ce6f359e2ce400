# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What can go wrong at the door, and the exit code it means.

Exit codes: 0 done; 1 failed while running; 2 bad scene, parameter or argument; 3 replay differs.
"""


class UserError(Exception):
    """
    A scene, parameter or argument that cannot be used (exit code 2).

    The message is one line: what, where, got, allowed, cure.
    """

    exit_code = 2


class RunError(Exception):
    """
    A run that began and could not be finished (exit code 1).

    The message is one line and says what is safe.
    """

    exit_code = 1
