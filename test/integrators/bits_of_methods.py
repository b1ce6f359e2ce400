# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The bits to which every integrator comes on bodies and points that are linked, and on tops: also a
program, which prints whether kernels are compiled, and then a line for each.

One of each scheme comes on what is linked. Those that differ from it in how a body turns alone
come on tops, which turn alone; that they are linked is left to `in_full`, and so are those that
differ in coefficients alone, and that something turns with a top, as with what is linked.
"""

import hashlib
import sys

from rigid_body_sim import Simulation
from rigid_body_sim.physics.compile import kernels
from rigid_body_sim.physics.integration.integrators import INTEGRATORS

if __name__ == '__main__':
    import scenes
else:
    from . import scenes

NAMES = sorted(INTEGRATORS)
# of the scheme and the free rotation of another of them: other coefficients alone
ALIKE = {'blanes_moan4', 'dmv2', 'dmv4', 'dmv8', 'implicit_euler', 'rk8'}
SHORT, LONG = 8, 20  # [tick] with a command, and as many again: a wrong operation shows at once


def lines(*in_full):
    """
    Give name and digest of each integrator.
    """
    linked = NAMES if in_full else scenes.OF_EACH_KIND
    ticks = LONG if in_full else SHORT
    for name in NAMES if in_full else sorted({*NAMES} - ALIKE):
        if name in scenes.TURNING:
            bits = bits_of_bodies(name, ticks, linked=name in linked, in_full=bool(in_full))
        else:
            bits = bits_of_points(name, ticks)
        yield f'{name} {hashlib.sha256(bits).hexdigest()}'


def bits_of_points(name, ticks):
    sim = Simulation(scenes.linked_points(), integrator=name)
    sim.set_wrench('b', force=(1.0, 2.0, 3.0))
    sim.step(2 * ticks)
    return sim.state_bytes()


def bits_of_bodies(name, ticks, *, linked, in_full):
    bodies = scenes.linked_bodies(name)
    tops = scenes.top(omega=(3.0, 10.0, 2.0), dt=0.02), scenes.top(omega=(30.0, 3.0, 1.0), dt=0.01)
    bits = b''
    for scene in (*[bodies] * linked, *tops):
        sim = Simulation(scene, integrator=name)
        first = scene.bodies[0].name
        sim.set_wrench(first, force=(1.0, 2.0, 3.0), torque=(0.1, 0.2, -0.3))
        sim.step(ticks)
        if scene is bodies or in_full:  # alone it makes one more kernel
            sim.set_wrench(first, force=(1.0, 2.0, 3.0), torque=(0.1, 0.2, -0.3), frame='body')
        sim.step(ticks)
        bits += sim.state_bytes() + sim.state.values.tobytes()
    return bits


if __name__ == '__main__':
    print(kernels.COMPILED)
    print(*lines(*sys.argv[1:]), sep='\n')
