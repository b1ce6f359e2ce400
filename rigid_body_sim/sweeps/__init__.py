# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Ensembles: many runs of one scene in which keys differ, and one table of what came of them."""

GROUPS = ('last', 'extremes', 'energy')  # what a row may hold beside what was varied
DONE, REFUSED, DIVERGED, FAILED = 'done', 'refused', 'diverged', 'failed'  # status of a run
