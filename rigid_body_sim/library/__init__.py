# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What Python users hold in their hands: a simulation with its runs, a run as arrays, bags as runs,
tables, checkpoints, pages in a notebook. `import rigid_body_sim as rbs` has all of it by name.
"""
