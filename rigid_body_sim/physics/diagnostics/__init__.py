# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""What can be told of a run beside its state: invariants, step limits, accelerations."""
