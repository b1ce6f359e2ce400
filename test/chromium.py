# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""The browser that the tests of pages look through: the one that films are drawn with."""

from rigid_body_sim.view.chromium import NAMES, Page, find, page

__all__ = ['NAMES', 'Page', 'find', 'page']
