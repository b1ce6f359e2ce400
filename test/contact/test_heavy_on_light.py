# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Heavy on light stands, put down exactly or from a millimetre above, or warns before it is through.
"""

import numpy as np
import pytest

from rigid_body_sim.physics.errors import SimulationDiverged
from rigid_body_sim.physics.simulation import Simulation

from .touching import ball, box, ground, heap, scene

EDGE = 0.2  # [m] of what is light
MILLIMETRE = 1e-3


def arrangement(seed, ratio, *, gap):
    """
    Cubes of 1 kg under a box of so many kilograms, whose middle is 3 cm and more inside of what
    they carry, `gap` [m] above them: one cube, one beside the middle, two, three or six, or two
    such pairs on each other. Return the scene, and the indices of what is heavy.
    """
    rng = np.random.default_rng(seed)
    form = rng.choice(['one', 'beside', 'two', 'three', 'six', 'pairs'])
    rough = {'friction': float(rng.choice([0.3, 0.5, 0.8]))}
    count = {'two': 2, 'three': 3, 'six': 6}.get(form, 1)
    angles = rng.uniform(0, 2 * np.pi) + 2 * np.pi * np.arange(count) / count
    radius = {1: 0.0, 2: 0.25, 3: 0.25, 6: 0.35}[count]
    lights = [
        box(
            f'light{i}', EDGE, (radius * np.cos(a), radius * np.sin(a), 0.5 * EDGE), material=rough
        )
        for i, a in enumerate(angles)
    ]
    place = rng.uniform(-0.07, 0.07, size=2) if form == 'beside' else (0.0, 0.0)
    wide, high = 2 * radius + EDGE * rng.uniform(0.8, 1.5), EDGE * rng.uniform(0.5, 1.5)
    size = (wide, wide, high)
    bottom = EDGE + gap
    heavies = [
        box('heavy', size, (*place, bottom + 0.5 * high), mass=ratio, material=rough),
    ]
    if form == 'pairs':
        bottom += high + gap
        lights.append(box('upper', EDGE, (0, 0, bottom + 0.5 * EDGE), material=rough))
        bottom += EDGE + gap
        heavies.append(
            box('top', size, (0, 0, bottom + 0.5 * high), mass=ratio, material=rough),
        )
    bodies = [ground(material=rough), *lights, *heavies]
    first = 1 + len(lights)
    return Simulation(scene(bodies, dt=0.004)), np.arange(first, first + len(heavies))


def falls(sim, heavies, *, gap, ticks):
    """
    Let ticks pass; give after each how far what is heavy is too low [m] at most, and the warnings.
    """
    at_rest = sim.state.position[heavies, 2] - gap * (1 + 2 * np.arange(len(heavies)))
    for _ in range(ticks):
        sim.step()
        yield (at_rest - sim.state.position[heavies, 2]).max(), sim.overlap_warnings


@pytest.mark.parametrize(
    ('seed', 'gap'),
    [
        *((seed, 0.0) for seed in (1, 2, 3)),  # two, two pairs, six
        (3, MILLIMETRE),
        # a hundred passes and more in each substep
        *(
            pytest.param(seed, MILLIMETRE, marks=pytest.mark.long)
            for seed in (0, 1, 2, 4, 5, 6, 7)
        ),
        *(pytest.param(seed, 0.0, marks=pytest.mark.long) for seed in (0, 4, 5, 6, 7)),
    ],
)
def test_heavy_stands_on_light_within_a_millimetre(seed, gap):
    """
    From 1:100 to 1:10^4, put down exactly or from a millimetre: what a contact yields is at most
    0.0015 of the radius of the smaller, 0.26 mm, at each of up to four joints of the load. Beyond
    1:1000 a tick may warn of what stands all the same.
    """
    ratio = 10 ** np.random.default_rng(seed + 100).uniform(2, 4)
    sim, heavies = arrangement(seed, ratio, gap=gap)
    for sunk, warnings in falls(sim, heavies, gap=gap, ticks=300):
        assert sunk < 4 * 0.26 * MILLIMETRE
        assert ratio > 1000 or not warnings


def until_it_fails(sim, heavies, *, goes_on=False):
    """
    Let 300 ticks pass, until what is heavy is a tenth of an edge too low, or numbers run out; or,
    unless it goes on, warnings come, behind which nothing is asked of it. Give how far it went [m]
    before the first warnings, whether it failed, and these.
    """
    silent, first = 0.0, {}
    try:
        for sunk, warnings in falls(sim, heavies, gap=MILLIMETRE, ticks=300):
            first = first or warnings
            silent = silent if first else max(silent, sunk)
            failed = sunk > 0.1 * EDGE
            if failed or (first and not goes_on):
                return silent, failed, first
    except SimulationDiverged:
        return silent, True, first
    return silent, False, first


@pytest.mark.parametrize(
    'seed', [*range(4), *(pytest.param(seed, marks=pytest.mark.long) for seed in range(4, 8))]
)
def test_what_is_too_heavy_warns_before_it_is_through(seed):
    """
    From 3 x 10^5 to 10^8 kg on 1 kg: some of it the solver carries, of the rest it says so before
    anything is a tenth of an edge too low, goes through what is light, or throws it away.
    """
    ratio = 10 ** np.random.default_rng(seed + 200).uniform(5.5, 8)
    silent, failed, warnings = until_it_fails(*arrangement(seed, ratio, gap=MILLIMETRE))
    assert silent < 5 * MILLIMETRE
    assert warnings or not failed


def test_a_warning_names_the_pair_and_the_cure():
    sim, heavies = arrangement(0, 1e9, gap=MILLIMETRE)
    _, failed, warnings = until_it_fails(sim, heavies, goes_on=True)
    assert failed
    text = next(iter(warnings.values()))
    assert "'heavy'" in text and "'light0'" in text
    assert 'sinking into each other' in text and 'smaller dt' in text


def mixed_heap(seed):
    """
    Cubes and balls of 0.1 to 10 kg that fall onto each other.
    """
    rng = np.random.default_rng(seed)
    bodies = [ground()]
    for i in range(20):
        place = (*rng.uniform(-0.15, 0.15, 2), 0.3 + 0.25 * i)
        mass = float(np.exp(rng.uniform(np.log(0.1), np.log(10))))
        turn = rng.normal(size=3)
        if i % 3 == 2:
            bodies.append(ball(f'b{i}', 0.1, place, mass=mass, turn=turn))
        else:
            bodies.append(box(f'b{i}', EDGE, place, mass=mass, turn=turn))
    return bodies


@pytest.mark.parametrize(
    'bodies', [mixed_heap(0), mixed_heap(1), heap(15)], ids=['mixed', 'other', 'alike']
)
def test_nothing_is_left_sinking_in_ordinary_heaps(bodies):
    """
    What comes down at 7 m/s may overlap by a tenth for a tick; that is another warning.
    """
    sim = Simulation(scene(bodies, dt=0.004))
    sim.step(500)
    assert not [text for text in sim.overlap_warnings.values() if 'sinking' in text]


@pytest.mark.parametrize('ratio', [10.0, 100.0])
def test_a_blow_of_something_heavy_is_not_warned_of(ratio):
    """
    From half a metre onto a light cube: what one substep leaves is gone in the next.
    """
    light, heavy = box('light', EDGE, (0, 0, 0.5 * EDGE)), box('h', EDGE, (0, 0, 0.8), mass=ratio)
    sim = Simulation(scene([ground(), light, heavy], dt=0.004))
    sim.step(250)
    assert not sim.overlap_warnings
