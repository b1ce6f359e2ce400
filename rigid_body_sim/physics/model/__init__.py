# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is simulated: bodies, shapes, their mass properties, attitudes; the scene as records."""
