# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Maps of free rotation: an attitude and a fixed angular momentum go in, the attitude a while later
comes out.
"""
