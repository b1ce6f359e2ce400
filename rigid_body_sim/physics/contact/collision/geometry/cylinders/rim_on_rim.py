# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The rims of two cylinders where they meet: the nearest points of two circles, exact.

    x(t) = e + r (u cos t + v sin t)        e middle of the end, u and v across the axis
    d = x_B - x_A,   d . x_A' = d . x_B' = 0

by Newton's method for 1/2 |d|^2, from where two turned prisms meet, whose chords are up to 11
degrees off. The normal is across both rims, along x_A' x x_B', so it lies in the planes of axis
and point of both: what has no friction there does not change the spin about either axis.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision import pose
from rigid_body_sim.physics.contact.collision.geometry.cylinders.mantle import UNDECIDED
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    NORMAL,
    POINT,
    POINTS,
    SEPARATION,
    TINY,
    write_normal,
    write_point,
)
from rigid_body_sim.physics.contact.collision.shape_parameters import HALF_LENGTH, RADIUS
from rigid_body_sim.physics.vectors import add, add_scaled, cross, dot, load, scale, subtract

Array = NDArray[np.float64]

ON_RIMS = 210.0  # feature; + 1 at the upper end of A, + 2 at that of B
STEPS = 16  # of Newton's method, at most
LONGEST = 0.3  # [rad] of a step: beyond, the circles bend away from their parabolas
SETTLED = 1e-12  # [rad] of a step: round-off
DEEP = 0.01  # [-] of the smaller radius: what overlaps by more may part sooner along another axis
SKEW = 0.01  # [-] squared sine of the angle between two rims, above which they have one normal


class _Rim(NamedTuple):
    """A circle: middle [m], u, axis out of the end, v, radius [m]."""

    middle: Any
    along_u: Any
    out: Any
    along_v: Any
    radius: float


@inline
def _rim_near(parameters: Array, shape: int, poses: Array, place: int, point: Any) -> Any:
    """Return the rim of a cylinder that is nearer to a point, with that at the angle 0."""
    center, out = load(poses, place), pose.axis(poses, place, 2)
    if dot(out, subtract(point, center)) < 0.0:
        out = scale(-1.0, out)
    middle = add_scaled(center, parameters[shape + HALF_LENGTH], out)
    way = subtract(point, middle)
    way = add_scaled(way, -dot(way, out), out)
    size = math.sqrt(dot(way, way))
    along_u = scale(1.0 / size, way) if size * size > TINY else pose.axis(poses, place, 0)
    return _Rim(middle, along_u, out, cross(out, along_u), parameters[shape + RADIUS])


@inline
def _arm(rim: Any, angle: float) -> Any:
    """Return the way from the middle of a rim to its point at an angle [m]."""
    along = scale(rim.radius * math.cos(angle), rim.along_u)
    return add_scaled(along, rim.radius * math.sin(angle), rim.along_v)


@inline
def _faces(rim: Any, arm: Any, normal: Any) -> bool:
    """Tell whether a normal leaves a cylinder between its mantle and its end."""
    return dot(normal, arm) >= 0.0 and dot(normal, rim.out) >= 0.0


@kernel
def _nearest_angles(rim_a: Any, rim_b: Any) -> Any:
    """Return the angles of the nearest points of two rims, and whether they were found."""
    angle_a, angle_b, found = 0.0, 0.0, False
    for _ in range(STEPS):
        arm_a, arm_b = _arm(rim_a, angle_a), _arm(rim_b, angle_b)
        way = subtract(add(rim_b.middle, arm_b), add(rim_a.middle, arm_a))
        along_a, along_b = cross(rim_a.out, arm_a), cross(rim_b.out, arm_b)
        slope_a, slope_b = -dot(way, along_a), dot(way, along_b)
        bend_a = dot(along_a, along_a) + dot(way, arm_a)
        bend_b = dot(along_b, along_b) - dot(way, arm_b)
        both = -dot(along_a, along_b)
        determinant = bend_a * bend_b - both * both
        if not (determinant > 0.0 and bend_a > 0.0):
            break
        step_a = (both * slope_b - bend_b * slope_a) / determinant
        step_b = (both * slope_a - bend_a * slope_b) / determinant
        longest = max(abs(step_a), abs(step_b))
        if longest > LONGEST:
            step_a, step_b = step_a * (LONGEST / longest), step_b * (LONGEST / longest)
        angle_a, angle_b = angle_a + step_a, angle_b + step_b
        if longest <= SETTLED:
            found = True
            break
    return angle_a, angle_b, found


@kernel
def rim_on_rim(
    parameters: Array, shape_a: int, shape_b: int, poses: Array, pose_a: int, pose_b: int,
    count: int, margin: float, found: Array,
) -> int:  # fmt: skip
    """
    Find the point between the rims of two cylinders near the deepest point of their prisms, of
    which there are so many, or return UNDECIDED and leave these as they are.
    """
    deepest = POINTS
    for place in range(POINTS, POINTS + POINT * count, POINT):
        if found[place + SEPARATION] < found[deepest + SEPARATION]:
            deepest = place
    point, of_prisms = load(found, deepest), load(found, NORMAL)
    rim_a = _rim_near(parameters, shape_a, poses, pose_a, point)
    rim_b = _rim_near(parameters, shape_b, poses, pose_b, point)
    angle_a, angle_b, is_found = _nearest_angles(rim_a, rim_b)
    if not is_found:
        return UNDECIDED
    arm_a, arm_b = _arm(rim_a, angle_a), _arm(rim_b, angle_b)
    on_a, on_b = add(rim_a.middle, arm_a), add(rim_b.middle, arm_b)
    way, across = subtract(on_b, on_a), cross(cross(rim_a.out, arm_a), cross(rim_b.out, arm_b))
    least = rim_a.radius * rim_b.radius
    normal = across if dot(across, across) > SKEW * (least * least) else way
    square = dot(normal, normal)
    if not square > TINY:
        return UNDECIDED
    sign = 1.0 if dot(normal, of_prisms) > 0.0 else -1.0
    normal = scale(sign / math.sqrt(square), normal)
    gap = dot(normal, way)
    if gap < -DEEP * min(rim_a.radius, rim_b.radius):
        return UNDECIDED
    if not (_faces(rim_a, arm_a, normal) and _faces(rim_b, arm_b, scale(-1.0, normal))):
        return UNDECIDED
    if not gap <= margin:
        return 0
    write_normal(found, normal)
    feature = 1.0 if dot(rim_a.out, pose.axis(poses, pose_a, 2)) > 0.0 else 0.0
    feature += 2.0 if dot(rim_b.out, pose.axis(poses, pose_b, 2)) > 0.0 else 0.0
    write_point(found, 0, add_scaled(on_a, 0.5, way), gap, ON_RIMS + feature)
    return 1
