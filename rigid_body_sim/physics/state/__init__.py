# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where numbers that move are kept, and what can be read of them at one instant."""
