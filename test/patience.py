# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""How long a test waits for another process: only what hangs fails, never what is slow."""

PATIENCE = 300.0  # [s] for one answer of a running process; a busy machine takes seconds
HANGING = 1800.0  # [s] cold compilation of everything beside four busy processes takes a tenth
