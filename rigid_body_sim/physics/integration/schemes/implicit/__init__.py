# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Implicit schemes: the equations of a stage, their derivatives, how they are solved."""
