# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Free-rotation propagators: an attitude and a fixed angular momentum go in, the attitude a while
later comes out. In a splitting they are the drift between the kicks of the torques.
"""
