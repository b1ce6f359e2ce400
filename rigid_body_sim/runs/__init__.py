# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A run: commands in, ticks, messages out; on disk, and again from disk."""
