# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""YAML to Scene: the only reader of scene keys."""

from rigid_body_sim.scene.experiment import load_scene

__all__ = ['load_scene']
