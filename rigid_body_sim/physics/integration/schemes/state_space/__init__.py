# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the stages of a Runge–Kutta step act on: points, quaternions, matrices, or no rotation."""
