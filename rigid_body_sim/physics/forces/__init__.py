# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What acts on bodies: `elements` one force, one file; what is held, when it acts, and the kernel
that adds it up.
"""
