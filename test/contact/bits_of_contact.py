# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The bits to which a heap comes, and discs and a capsule that fall over: also a program, which
prints whether kernels are compiled, and then a line for each. Of what meets at instants, with
nothing but its weight, the kernel is its own, which knows nothing else: no test shares it.
"""

import sys

import numpy as np

from rigid_body_sim.physics.compile import kernels
from rigid_body_sim.physics.model.scene import Body
from rigid_body_sim.physics.model.shapes import Capsule, Cylinder
from rigid_body_sim.physics.simulation import Simulation

if __name__ == '__main__':
    import inside
    import pytest
    from touching import ball, box, ground, heap, lean, motion, scene
else:
    from .touching import ball, box, ground, heap, lean, motion, scene


OWN = 'own kernels'


def a_heap(ticks):
    """The state of a heap that has come down."""
    sim = Simulation(scene(heap(3)))
    sim.step(ticks)
    return sim.state_bytes().hex()


def rims(ticks):
    """The state of discs and a capsule that fall over on a plane and a box."""

    def solid(name, shape, x, turn):
        start = motion((x, 0, 0.1), q=(0.3, 0.1, 0.2, 0.9273618495495703), turn=turn)
        inertia = np.diag([0.002, 0.002, 0.003])
        return Body(name, shape, 1.0, inertia=inertia, initial=start)

    bodies = [
        ground(), box('floor', 0.1, (0, 0, -0.05), fixed=True),
        solid('coin', Cylinder(0.08, 0.01), 0.0, (2.0, 9.0, 1.0)),
        solid('coin on the ground', Cylinder(0.08, 0.01), 0.5, (2.0, 9.0, 1.0)),
        solid('capsule', Capsule(0.05, 0.1), 1.0, (2.0, 3.0, 1.0)),
        ball('b', 0.05, (0.02, 0, 0.3)),
    ]  # fmt: skip
    sim = Simulation(scene(bodies))
    sim.step(ticks)
    return sim.state_bytes().hex()


def of_weight_alone(ticks):
    """The state of boxes and a ball that meet at their instants: of a kernel of their own."""
    bodies = [ground(), ball('b', 0.1, (0, 0, 0.3))]
    bodies += [box(f'c{i}', 0.2, (0.05, 0, 0.7 + 0.3 * i)) for i in range(2)]
    sim = Simulation(lean(bodies, mode='event'))
    sim.step(ticks)
    return sim.state_bytes().hex()


def lines(*how):
    """Give name and bits of each; how: in full, or of kernels of their own."""
    if OWN in how:
        yield of_weight_alone(150)
        return
    for end_of, ticks in ((a_heap, 100), (rims, 80)) if how else ((a_heap, 72), (rims, 50)):
        yield f'{end_of.__name__} {end_of(ticks)}'


if __name__ == '__main__':
    if OWN not in sys.argv:
        inside.share_kernels(pytest.MonkeyPatch())
    print(kernels.COMPILED)
    print(*lines(*sys.argv[1:]), sep='\n')
