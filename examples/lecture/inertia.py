# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Mass, centre and inertia: sums over points, integrals over volumes, principal axes."""

import numpy as np
from lesson import claim

from rigid_body_sim import Simulation, load_scene

POINTS = np.array([[1, 0, 0], [0, 2, 0], [0, 0, 3], [-1, -1, 1.0]])
MASSES = np.array([1.0, 2.0, 3.0, 4.0])
A, B, C, RHO = 0.4, 0.2, 0.1, 250.0  # [m], [kg/m^3]


def body(**keys):
    """The body that a scene makes of these keys."""
    return load_scene({'dt': 0.001, 'bodies': [{'name': 'it', **keys}]}).bodies[0]


def tensor(masses, r):
    """I = Σ m (|r|² 1 - r rᵀ) about the origin [kg m²]."""
    return sum(m * (s @ s * np.eye(3) - np.outer(s, s)) for m, s in zip(masses, r))


given = [{'mass': m, 'position': list(p)} for m, p in zip(MASSES, POINTS)]
jack = body(shape={'type': 'particles', 'particles': given})
centre = MASSES @ POINTS / MASSES.sum()
claim('sums: the centre is Σ m r / Σ m', jack.center_of_mass - centre, within=1e-14, unit='m')
summed = tensor(MASSES, POINTS - centre)
claim('sums: I = Σ m (r² 1 - r rᵀ)', jack.inertia - summed, within=1e-13, unit='kg m²')
parallel = summed + MASSES.sum() * (centre @ centre * np.eye(3) - np.outer(centre, centre))
claim(
    'parallel axes: I + m (c² 1 - c cᵀ)',
    parallel - tensor(MASSES, POINTS),
    within=1e-12,
    unit='kg m²',
)

box = body(shape={'type': 'box', 'size': [A, B, C]}, density=RHO)
mass = RHO * A * B * C
exact = mass / 12 * np.diag([B**2 + C**2, A**2 + C**2, A**2 + B**2])
claim('integrals: a box has m/12 (b² + c², …)', box.inertia - exact, within=1e-15, unit='kg m²')
n = 40  # the same integral as a sum over small cubes: the error falls as 1/n²
grid = [(np.arange(n) + 0.5) / n - 0.5] * 3
cells = np.stack(np.meshgrid(*grid), axis=-1).reshape(-1, 3) * (A, B, C)
counted = mass / len(cells) * (np.sum(cells**2) * np.eye(3) - cells.T @ cells)
claim(
    'a sum over 64000 cells comes near',
    counted / np.trace(exact) - exact / np.trace(exact),
    within=1e-3,
)

moments, axes_of = np.linalg.eigh(jack.inertia)
turned = axes_of.T @ jack.inertia @ axes_of
claim(
    'principal axes make the tensor diagonal',
    turned - np.diag(moments),
    within=1e-13,
    unit='kg m²',
)
axis = np.array([1, 2, 2]) / 3
simulation = Simulation(load_scene({'dt': 0.001, 'bodies': [
    {'name': 'it', 'shape': {'type': 'particles', 'particles': given}}]}))  # fmt: skip
moment = simulation.moment_of_inertia('it', direction=axis)
claim(
    'the moment about n is nᵀ I n', moment - axis @ jack.inertia @ axis, within=1e-13, unit='kg m²'
)


def draw(axes):
    """The error of the sum over cells against the number of cells along an edge."""
    counts = np.array([2, 4, 8, 16, 32])
    errors = 1.0 / counts**2  # of Σ over the integral of x², exactly
    measured = [abs(12 * np.mean(((np.arange(k) + 0.5) / k - 0.5) ** 2) - 1) for k in counts]
    axes.loglog(counts, measured, 'o', label='sum over cells')
    axes.loglog(counts, errors, label='1/n²')
    axes.set(xlabel='cells along an edge', ylabel='relative error of the moment')
