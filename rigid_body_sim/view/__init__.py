# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Pictures of a recorded run: what the bodies did, and what the conservation laws say about it."""
