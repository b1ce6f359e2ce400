# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Ground of triangles: its record, what is near a body, and what a body touches of it."""
