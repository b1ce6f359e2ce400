# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a kernel that advances a scene returns: how the ticks ended."""

DONE = 0.0  # all ticks done; NaN where a number left the finite ones
DID_NOT_CONVERGE = 1.0  # its equations could not be solved
TOO_MANY_EVALUATIONS = 2.0  # a tick asks for more of them than anybody would wait for
