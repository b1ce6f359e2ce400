# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Scenes of every kind that a kernel may be made for, each run with its own kernel and with the one
that tests share (`inside.share_kernels`): a program, for `test_same_bits.py`.

Prints of each scene whether both gave the same bits, whether the shared kernel knows more, and
whether anything acted: touched, or pulled where nothing may touch.
"""

from dataclasses import replace

import inside
import numpy as np
import pytest
from touching import CORNERS, ball, box, ground, lean, stack

from rigid_body_sim.physics.forces.elements.drag import Drag
from rigid_body_sim.physics.forces.elements.spring import Spring
from rigid_body_sim.physics.model.height_field import height_field
from rigid_body_sim.physics.model.scene import (
    Body,
    MassFlow,
    Oscillation,
    Pivot,
    PrescribedMotion,
)
from rigid_body_sim.physics.model.shapes import ConvexHull
from rigid_body_sim.physics.simulation import Simulation

TICKS = 10
# where only weight acts, and masses flow, bodies are moved as told or impacts are at their
# instants, the shared kernel adds its work up over substeps, not the tick, and evaluates what acts
# anew as a tick begins; and it evaluates a spring in each substep, where the kernel of the scene
# corrects that of the last one
ROUND_OFF = {'flows': 1e-14, 'driven': 1e-14, 'pulled': 1e-14}
ROUND_OFF['belt'] = 3e-14  # a brick strikes it in the last tick: some more, of 2 rad/s
ROUND_OFF['events, balls'] = 1e-13  # a blow by which one spins at 2 rad/s: 4e-14 of it
ROUND_OFF['driven, pulled'] = ROUND_OFF['driven'] + ROUND_OFF['pulled']

BRICK = box('brick', (0.3, 0.2, 0.1), (0, 0, 0.07), turn=(1, 2, 3))
BALL = ball('ball', 0.1, (0.05, 0, 0.25), velocity=(0, 0, -1))
OTHER = ball('other', 0.1, (0, 0, 0.099), turn=(1, 2, 3))
LIVELY, ROLLS = {'restitution': 0.5}, {'rolling_friction': 0.02}
GROUND = ground(material=LIVELY)
ROUGH = ground(material=ROLLS)
SLAB = box('slab', (4, 4, 0.2), (0, 0, -0.1), fixed=True, material=LIVELY)
SHAKEN = replace(SLAB, motion=PrescribedMotion(heave=(Oscillation(0.01, 0.1),)))
BELT = replace(SLAB, surface_velocity=(1.0, 0.0, 0.0))
HUNG = replace(BRICK, pivot=Pivot((0.14, 0.0, 0.0), (0.1, 0.0, 0.07)))
LEAKING = replace(BRICK, mass_flow=MassFlow(-0.2))
HILL = height_field([[0.0, 0.1, 0.0], [0.05, 0.0, 0.1]], spacing=1.0, origin=(-1.0, -0.5, 0.0))
# at rest: from the third tick on the manifold follows the two (`collision.recycling`)
TILE = Body('tile', ConvexHull((2, 2, 0.1) * CORNERS), 0.0, fixed=True, material=SLAB.material)
SLATE = replace(
    BRICK, name='slate', shape=ConvexHull((0.15, 0.1, 0.05) * CORNERS),
    initial=replace(BRICK.initial, position=(0, 0, 0.15), angular_velocity=(0, 0, 0)),
)  # fmt: skip
SPRING = Spring('brick', 'world', 40.0, b_point=(0.0, 0.0, 0.5))
RULE = {'bodies': ['brick', 'ball'], 'friction': 0.1}
SCENES = {
    'neither bounces nor rolls': ((ground(), BRICK, BALL), {}),
    'bounces': ((GROUND, BRICK, BALL), {}),
    'balls': ((GROUND, BALL, OTHER), {}),
    'rolls': ((ROUGH, BRICK, BALL), {}),
    'sleeps': ((GROUND, BRICK, BALL), {'sleeping': True}),
    'pulled': ((GROUND, BRICK, BALL), {'forces': (SPRING,)}),
    'braked': ((ROUGH, BRICK, BALL), {'forces': (Drag('ball', linear=0.3),)}),
    'ignores': ((GROUND, BRICK, BALL), {'ignore': [['brick', 'ball']]}),
    'pairs': ((GROUND, BRICK, BALL), {'pairs': [RULE]}),
    'stack': (stack(3), {}),
    'without contact': ((BRICK,), {'mode': 'none', 'forces': (SPRING,)}),
    'driven': ((SHAKEN, BRICK, BALL), {}),
    'belt': ((BELT, BRICK, BALL), {}),
    'pivoted': ((GROUND, HUNG, BALL), {}),
    'flows': ((GROUND, LEAKING, BALL), {}),
    'triangles': ((Body('hill', HILL, 0.0, fixed=True), BRICK, BALL), {}),
    'hulls': ((TILE, SLATE), {}),
    'events': ((GROUND, BRICK, BALL), {'mode': 'event'}),
    'driven, pulled': ((SHAKEN, BRICK, BALL), {'forces': (SPRING,)}),
    'events, balls': ((GROUND, BALL, OTHER), {'mode': 'event'}),
    'events, pulled': ((GROUND, BRICK, BALL), {'mode': 'event', 'forces': (SPRING,)}),
    'events, flows': ((GROUND, LEAKING, BALL), {'mode': 'event'}),
    'events, driven': ((SHAKEN, BRICK, BALL), {'mode': 'event'}),
    'events, pivoted': ((GROUND, HUNG, BALL), {'mode': 'event'}),
}


def run(bodies, settings):
    """
    Give the states of all ticks, how many kinds of forces and pairs of shapes the kernel knows,
    and whether anything acted.
    """
    sim = Simulation(lean(bodies, **settings))
    may_touch = sim.scene.contact['mode'] != 'none'
    known = len(inside.elements(sim).names)
    bits, acts = b'', not may_touch and known > 0
    for _ in range(TICKS):
        sim.step()
        bits += sim.state.values.tobytes()
        acts |= len(sim.contacts()) > 0
    return bits, known + (len(inside.known_pairs(sim)) if may_touch else 0), acts


def main():
    for name, scene in SCENES.items():
        own, known, acts = run(*scene)
        with pytest.MonkeyPatch.context() as patch:
            inside.share_kernels(patch)
            shared, known_shared, _ = run(*scene)
        same = own == shared
        if name in ROUND_OFF:
            apart = np.frombuffer(own) - np.frombuffer(shared)
            same = np.abs(apart).max() < ROUND_OFF[name]
        print(f'{name}: {same} {known < known_shared} {acts}')


if __name__ == '__main__':
    main()
