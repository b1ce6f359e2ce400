# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The bits to which every integrator comes on bodies and points that are linked, and on tops: also a
program, which prints whether kernels are compiled, and then a line for each.
"""

import hashlib

from rigid_body_sim import Simulation
from rigid_body_sim.physics.compile import kernels
from rigid_body_sim.physics.integration.integrators import INTEGRATORS

if __name__ == '__main__':
    import scenes
else:
    from . import scenes

NAMES = sorted(INTEGRATORS)
ONE_OF_EACH_SCHEME = {type(INTEGRATORS[name].scheme): name for name in NAMES}.values()


def lines():
    """
    Give name and digest of each integrator.
    """
    for name in NAMES:
        bits = bits_of_bodies(name) if name in scenes.TURNING else bits_of_points(name)
        yield f'{name} {hashlib.sha256(bits).hexdigest()}'


def bits_of_points(name):
    sim = Simulation(scenes.linked_points(), integrator=name)
    sim.set_wrench('b', force=(1.0, 2.0, 3.0))
    sim.step(40)
    return sim.state_bytes()


def bits_of_bodies(name):
    linked = scenes.linked_bodies(name)
    tops = scenes.top(omega=(3.0, 10.0, 2.0), dt=0.02), scenes.top(omega=(30.0, 3.0, 1.0), dt=0.01)
    bits = b''
    for scene in (linked, *tops):
        sim = Simulation(scene, integrator=name)
        first = scene.bodies[0].name
        sim.set_wrench(first, force=(1.0, 2.0, 3.0), torque=(0.1, 0.2, -0.3))
        sim.step(20)
        if scene is linked or name in ONE_OF_EACH_SCHEME:  # alone it makes one more kernel
            sim.set_wrench(first, force=(1.0, 2.0, 3.0), torque=(0.1, 0.2, -0.3), frame='body')
        sim.step(20)
        bits += sim.state_bytes() + sim.state.values.tobytes()
    return bits


if __name__ == '__main__':
    print(kernels.COMPILED)
    print(*lines(), sep='\n')
