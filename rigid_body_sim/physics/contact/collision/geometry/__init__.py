# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Where two shapes are nearest or deepest, and the points in which they touch: what the pair kernels
are made of.

`manifold` says what every pair kernel gives, and where it may keep what; `manifold_reduction` and
`polyhedra.extreme_points` choose up to four of many points. `boxes` holds the faces and edges of
two boxes, `cylinders` true round rims; `polyhedra` everything else that is convex: its distance
by GJK (`gjk`), its overlap by the separating axis test (`separating_axes`), its patches by
clipping an incident against a reference face (`face_clipping`).
"""
