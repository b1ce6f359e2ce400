# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Collision detection: which colliders meet in a tick, and where.

    collider, pose : what collides and where it stands, as records of the arrays of kernels
    swept_aabbs    : how far each collider reaches in a tick, speculative margin of a pair
    neighbour_list : broad phase, the pairs that may meet, kept over ticks; `hash_grid` below it
    narrow_phase   : contact manifolds of those pairs, by the pair kernels in `pairs`
    ghosts         : manifolds that would stop what nothing is in the way of are taken out again
    conservative_advancement : whether a pair misses, axis by axis (CCD); `free_motion`, `support`
"""
