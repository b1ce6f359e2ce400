# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""The domain of a node, from the environment: asked before the middleware stumbles over it."""

from __future__ import annotations

import os
import re

from rigid_body_sim.errors import UserError

VARIABLE = 'ROS_DOMAIN_ID'
MOST = 232  # the last domain whose UDP ports exist


def check_domain() -> None:
    """Refuse a domain that there is not; UserError."""
    given = os.environ.get(VARIABLE, '')
    is_number = re.fullmatch('[0-9]{1,3}', given, re.ASCII) is not None
    if given and not (is_number and int(given) <= MOST):
        raise UserError(f'{VARIABLE} is {given[:80]!r}; allowed: a whole number from 0 to {MOST}')
