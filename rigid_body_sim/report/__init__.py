# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Speed against error: problems with exact answers, how they are measured, and what comes of it.

    problems/  one problem, one file: a scene, its exact end, the measure of error
    measure    error, drift and cost of every point
    results    the points as JSON and CSV
    pareto     the front, the cheapest point at an error, and the verdict in words

Imports physics, exact and scene; nobody imports this room but the verb `report`.
"""
