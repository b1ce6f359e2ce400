# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Which colliders meet in a tick, and where: reaches, kept pairs, manifolds, what is too fast."""
