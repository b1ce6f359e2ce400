# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What contact may do to energy: a bounce returns no more than the impact took, and nothing else
gives any.

    account             what the energy of each body would be without contacts
    restitution_bound   bounds what a bounce gives back
    gain_bound          takes back what contact gave by its errors
    kept_motion         the motion that contacts cannot change, which such a bound leaves as it is
"""
