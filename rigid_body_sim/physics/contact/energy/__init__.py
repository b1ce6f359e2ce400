# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""What contact may do to energy: a bounce returns no more than it took, gains are taken back."""
