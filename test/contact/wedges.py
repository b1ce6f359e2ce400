# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Balls between walls: a sequence of single impacts, each by Newton's law and then Coulomb's, as the
law for what a tick makes of them.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

R = 0.1  # [m] radius of the balls, of 1 kg


@dataclass(frozen=True)
class Flight:
    """
    Centre [m], velocity [m/s] and angular velocity [rad/s] of a ball, world axes.
    """

    position: np.ndarray
    velocity: np.ndarray
    spin: np.ndarray


def walls(rng, angle):
    """
    Normals (2, 3) of two walls through the origin that have an angle [rad] between them.
    """
    axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn = math.pi - angle
    return np.array([axes[0], math.cos(turn) * axes[0] + math.sin(turn) * axes[1]])


def impact(flight, normal, restitution, friction):
    """
    The flight after an impact on a wall: v_n' = -e v_n, then friction sticks or slides.
    """
    velocity, spin = flight.velocity, flight.spin
    press = -(1.0 + restitution) * (normal @ velocity)
    slip = velocity - R * np.cross(spin, normal)
    slip = slip - (normal @ slip) * normal
    size = np.linalg.norm(slip)
    rub = min(2.0 / 7.0, friction * press / size if size > 0.0 else 1.0)
    turn = np.cross(-R * normal, -rub * slip) / (0.4 * R * R)
    return replace(flight, velocity=velocity + press * normal - rub * slip, spin=spin + turn)


def after_single_impacts(flight, normals, end, *, restitution, friction):
    """
    The flight at a time [s], without gravity, after all impacts on walls until then, in their
    order; the slowest approach of any [m/s], and how many there were.
    """
    time, slowest, count = 0.0, math.inf, 0
    while count < 100:
        gaps = normals @ flight.position - R
        speeds = normals @ flight.velocity
        meets = [
            max(gap / -speed, 0.0) if speed < -1e-12 else math.inf
            for gap, speed in zip(gaps, speeds, strict=True)
        ]
        wall = int(np.argmin(meets))
        if time + meets[wall] > end:
            break
        time += meets[wall]
        flight = replace(flight, position=flight.position + meets[wall] * flight.velocity)
        slowest = min(slowest, -(normals[wall] @ flight.velocity))
        flight = impact(flight, normals[wall], restitution, friction)
        count += 1
    last = flight.position + (end - time) * flight.velocity
    return replace(flight, position=last), slowest, count
