# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The stages of a Runge–Kutta step for rotations in the state of the lecture: a matrix R and the
angular momentum L.

    R' = [omega] R,   L' = torque,   omega = R I^-1 R^T L            world axes
        [omega] : the matrix of the cross product, [omega] v = omega x v

No explicit Runge–Kutta method keeps R^T R = 1: on a fixed axis explicit Euler stretches it by
1 + (h omega)^2 a step, the classical method shrinks it by 1 - (h omega)^6 / 72. That is what this
module is there to show; a quaternion is scaled to unit length and does not suffer from it.
Source: Baraff, Rigid Body Simulation (SIGGRAPH course notes, Physically Based Modeling).

R is kept from tick to tick, nine rows of `memory`; forces and reports see the quaternion of the
nearest rotation. With REORTHONORMALISE that rotation takes the place of R after each step. The
workspace of a block holds y = (R, L), then R of the stage, then the slopes K of each stage, twelve
rows each; R row by row. Compiled but not vectorised.
"""

from __future__ import annotations

import math

from rigid_body_sim.physics.compile.kernels import inline
from rigid_body_sim.physics.state.blocks import J1, J2, J3, LX, LY, LZ, QW, QX, QY, QZ, TX, TY, TZ

MATRIX = 576  # numbers of R in a block
TURN = 768  # numbers of y, and of a slope, in a block
TURN_START = 1344  # where the slopes begin
ITERATIONS = 40  # [-] of the polar decomposition; five are normal, more only far from a rotation

# bound for each tableau by `specialise`
STAGES = 1
A: tuple[float, ...] = (0.0,)  # the tableau, row by row
B: tuple[float, ...] = (1.0,)
REORTHONORMALISE = True


@inline
def _nearest_rotation(a, b, c, d, e, f, g, h, i):
    """
    Polar factor of a matrix given row by row: X <- (X + X^-T) / 2 (Higham, SIAM J. Sci. Stat.
    Comput. 7, 1986).
    """
    for _iteration in range(ITERATIONS):
        ca, cb, cc = e * i - f * h, f * g - d * i, d * h - e * g
        over = 1.0 / (a * ca + b * cb + c * cc)
        cd, ce, cf = c * h - b * i, a * i - c * g, b * g - a * h
        cg, ch, ci = b * f - c * e, c * d - a * f, a * e - b * d
        na, nb, nc = 0.5 * (a + ca * over), 0.5 * (b + cb * over), 0.5 * (c + cc * over)
        nd, ne, nf = 0.5 * (d + cd * over), 0.5 * (e + ce * over), 0.5 * (f + cf * over)
        ng, nh, ni = 0.5 * (g + cg * over), 0.5 * (h + ch * over), 0.5 * (i + ci * over)
        change = abs(na - a) + abs(nb - b) + abs(nc - c) + abs(nd - d) + abs(ne - e)
        change += abs(nf - f) + abs(ng - g) + abs(nh - h) + abs(ni - i)
        a, b, c, d, e, f, g, h, i = na, nb, nc, nd, ne, nf, ng, nh, ni
        if not change > 1e-9:  # the next change would be its square
            break
    return a, b, c, d, e, f, g, h, i


@inline
def _quaternion(a, b, c, d, e, f, g, h, i):
    """
    Quaternion of a rotation matrix given row by row (Shepperd, J. Guidance and Control 1, 1978).
    """
    trace = a + e + i
    if trace >= a and trace >= e and trace >= i:
        x, y, z, w = h - f, c - g, d - b, 1.0 + trace
    elif a >= e and a >= i:
        x, y, z, w = 1.0 + a - e - i, b + d, c + g, h - f
    elif e >= i:
        x, y, z, w = b + d, 1.0 + e - i - a, f + h, c - g
    else:
        x, y, z, w = c + g, f + h, 1.0 + i - a - e, d - b
    over = 1.0 / math.sqrt(x * x + y * y + z * z + w * w)
    return x * over, y * over, z * over, w * over


@inline
def write_quaternion(k, s, y, place):
    """
    Write the quaternion nearest to the matrix at a place of y, on the side of the one before.
    """
    m = place + k
    a, b, c, d, e, f, g, h, i = _nearest_rotation(
        y[m], y[m + 64], y[m + 128], y[m + 192], y[m + 256], y[m + 320], y[m + 384], y[m + 448],
        y[m + 512],
    )  # fmt: skip
    x, u, v, w = _quaternion(a, b, c, d, e, f, g, h, i)
    if x * s[k + QX] + u * s[k + QY] + v * s[k + QZ] + w * s[k + QW] < 0.0:
        x, u, v, w = -x, -u, -v, -w
    s[k + QX], s[k + QY], s[k + QZ], s[k + QW] = x, u, v, w


@inline
def matrix(x, y, z, w):
    """Matrix of a unit quaternion, row by row."""
    return (
        1.0 - 2.0 * (y * y + z * z),
        2.0 * (x * y - z * w),
        2.0 * (x * z + y * w),
        2.0 * (x * y + z * w),
        1.0 - 2.0 * (x * x + z * z),
        2.0 * (y * z - x * w),
        2.0 * (x * z - y * w),
        2.0 * (y * z + x * w),
        1.0 - 2.0 * (x * x + y * y),
    )


@inline
def begin(lanes, s, y, memory):
    """Start a step: y = (R, L)."""
    for k in range(lanes):
        for row in range(9):
            y[k + 64 * row] = y[k + 64 * row + TURN] = memory[k + 64 * row]
        y[k + 576], y[k + 640], y[k + 704] = s[k + LX], s[k + LY], s[k + LZ]


def move(stage, lanes, h, s, y):
    """
    Make the state of a stage from the slopes of those before it, and the quaternion for the forces
    to read.
    """
    for k in range(lanes):
        for row in range(12):
            total = y[k + 64 * row]
            for j in range(stage):
                total += h * A[stage * STAGES + j] * y[TURN_START + TURN * j + k + 64 * row]
            if row < 9:
                y[k + 64 * row + TURN] = total
            else:
                s[k + LX + 64 * (row - 9)] = total
        write_quaternion(k, s, y, TURN)


@inline
def slope_of(lanes, s, y, slope):
    """Slope of a stage."""
    for k in range(lanes):
        m = k + TURN
        a, b, c = y[m], y[m + 64], y[m + 128]
        d, e, f = y[m + 192], y[m + 256], y[m + 320]
        g, h, i = y[m + 384], y[m + 448], y[m + 512]
        lx, ly, lz = s[k + LX], s[k + LY], s[k + LZ]
        u = s[k + J1] * (a * lx + d * ly + g * lz)
        v = s[k + J2] * (b * lx + e * ly + h * lz)
        w = s[k + J3] * (c * lx + f * ly + i * lz)
        u, v, w = a * u + b * v + c * w, d * u + e * v + f * w, g * u + h * v + i * w
        slope[k], slope[k + 64], slope[k + 128] = v * g - w * d, v * h - w * e, v * i - w * f
        slope[k + 192], slope[k + 256], slope[k + 320] = (
            w * a - u * g,
            w * b - u * h,
            w * c - u * i,
        )
        slope[k + 384], slope[k + 448], slope[k + 512] = (
            u * d - v * a,
            u * e - v * b,
            u * f - v * c,
        )
        slope[k + 576], slope[k + 640], slope[k + 704] = s[k + TX], s[k + TY], s[k + TZ]


def end(lanes, h, s, y, memory):
    """y + h sum b K, and the quaternion nearest to it."""
    for k in range(lanes):
        for row in range(12):
            total = 0.0
            for j in range(STAGES):
                total += B[j] * y[TURN_START + TURN * j + k + 64 * row]
            y[k + 64 * row] += h * total
        write_quaternion(k, s, y, 0)
        s[k + LX], s[k + LY], s[k + LZ] = y[k + 576], y[k + 640], y[k + 704]
        if REORTHONORMALISE:
            a, b, c, d, e, f, g, u, v = matrix(s[k + QX], s[k + QY], s[k + QZ], s[k + QW])
            y[k], y[k + 64], y[k + 128], y[k + 192], y[k + 256] = a, b, c, d, e
            y[k + 320], y[k + 384], y[k + 448], y[k + 512] = f, g, u, v
        for row in range(9):
            memory[k + 64 * row] = y[k + 64 * row]
