# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Closed-form motions, shared by tests and the report.

Imports numpy, scipy and itself alone: an oracle shares no code with what it judges.
SI units; world axes, z up; quaternions xyzw, body to world; times of any shape.
"""
