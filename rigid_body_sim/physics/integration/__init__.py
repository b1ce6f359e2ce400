# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
From forces to motion.

`integrators` one method, one file; `schemes` how a tick is made of evaluations, kicks, drifts and
stages; `free_rotation` maps of a rotation without torque; `choose` the method for a tolerance.
"""
