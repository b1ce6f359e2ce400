# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Where two shapes are nearest or deepest, and the points in which they touch: what the pair kernels
are made of.

`manifold` says what every pair kernel gives; `two_boxes`, `box_faces`, `box_edges` serve boxes,
`hulls` to `polyhedra` convex polyhedra, `rim` and `cylinder_on_face` cylinders.
"""
