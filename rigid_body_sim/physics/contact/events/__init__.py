# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Islands of bodies that fall asleep when they rest, and what wakes them."""
