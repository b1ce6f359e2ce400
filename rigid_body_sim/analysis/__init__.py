# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a recording tells: poses, contacts, and the wrenches that explain a motion."""
