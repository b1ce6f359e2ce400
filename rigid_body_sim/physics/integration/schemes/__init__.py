# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
How a tick is made of force evaluations, kicks, drifts and stages: one module per family of
integrators.
"""
