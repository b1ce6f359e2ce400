# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Many runs in one simulation: bodies that feel nothing of each other move side by side, at a cost
per run that is a small share of what one alone takes.

A run may share a simulation with others where nothing of a tick is decided for all bodies at once:

    no bodies meet; the method makes steps of one length, plans nothing for a scene and solves no
    equations for it; nothing happens at instants of its own (forces over time, flows of mass,
    inertia over time, bodies moved as told); and, where an energy balance is kept, nothing works
    that has no potential, because such work is summed over a scene.

Those may share one that are alike in all that is of the scene and not of a body: tick length,
method and its options, gravity, what kinds of bodies and forces there are, in order. Then each
body meets the same kernel with the same numbers as alone, and a body does not feel which others
share its block (`test_invariants`). `pack_key` says so before, and the last run of each pack is
made alone too: if one bit differs, the whole pack is made again one by one, and says so.

A run that leaves the finite numbers is taken out of its pack; the others go on from where they
stood, bit for bit. It is made again alone.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Hashable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.integration import choose
from rigid_body_sim.physics.integration.integrators import INTEGRATORS
from rigid_body_sim.physics.model.scene import Body, Scene
from rigid_body_sim.physics.model.variable_mass import flow_of
from rigid_body_sim.physics.state.layout import STATE_OF_POINT, STATE_OF_TURN

MOST_BODIES = 4096  # in a pack: their arrays still fit into the cache of a core
TIMED = ('acts', 'kinks')  # what an element has that acts at instants of its own


def pack_key(scene: Scene, *, energy: bool) -> Hashable | None:
    """
    Tell with whom a run may share a simulation: all of the same key. None: with nobody.

    energy : whether an energy balance is kept
    """
    if scene.contact.get('mode', 'none') != 'none' or scene.integrator == choose.NAME:
        return None
    if scene.integrator not in INTEGRATORS or len(scene.bodies) > MOST_BODIES // 2:
        return None
    try:
        method = INTEGRATORS[scene.integrator].configured(scene.integrator_options)
    except InvalidModel:  # alone it is told what is wrong
        return None
    if method.controls_its_error or method.wants_derivatives or method.plan is not None:
        return None
    if method.is_reference or method.remembers is not None:
        return None
    if any(_is_timed(body) for body in scene.bodies):
        return None
    if any(hasattr(force, name) for force in scene.forces for name in TIMED):
        return None
    if energy and not all(force.conserves_energy() for force in scene.forces):
        return None
    return (
        scene.dt_ns,
        scene.integrator,
        repr(sorted(scene.integrator_options.items())),
        np.array(scene.gravity).tobytes(),
        tuple((body.is_point, body.fixed, body.pivot is None) for body in scene.bodies),
        tuple((force.TYPE, force.depends_on_velocity()) for force in scene.forces),
        tuple(force.conserves_energy() for force in scene.forces),
    )


def _is_timed(body: Body) -> bool:
    return (
        flow_of(body) is not None
        or body.mass_flow is not None
        or body.inertia_over_time is not None
        or body.motion is not None
    )


def packed_scene(scenes: Sequence[Scene]) -> Scene:
    """Put the bodies and forces of scenes side by side: of the first all, then of the next."""
    bodies: list[Body] = []
    forces: list[Any] = []
    for scene in scenes:
        names = {body.name: f'b{len(bodies) + i}' for i, body in enumerate(scene.bodies)}
        bodies += [dataclasses.replace(b, name=names[b.name], frames={}) for b in scene.bodies]
        forces += [_renamed(force, names) for force in scene.forces]
    return dataclasses.replace(
        scenes[0],
        name='pack',
        bodies=tuple(bodies),
        forces=tuple(forces),
        contact={'mode': 'none'},
        source=b'',
        files={},
    )


def _renamed(force: Any, names: dict[str, str]) -> Any:
    """Give a force element that acts on the bodies of other names."""
    changed: dict[str, Any] = {}
    for field in dataclasses.fields(force):
        kind, value = field.metadata['kind'], getattr(force, field.name)
        if kind in ('body', 'body_or_world'):
            changed[field.name] = names.get(value, value)
        elif kind == 'bodies':
            changed[field.name] = tuple(names[name] for name in value)
    return dataclasses.replace(force, **changed)


def most_in_a_pack(scene: Scene) -> int:
    """Count the runs that share one simulation at most."""
    return max(1, MOST_BODIES // len(scene.bodies))


def state_of_some(state: bytes, stays: NDArray[np.bool_], scene: Scene) -> bytes:
    """
    Cut the state of some runs out of that of a pack: of each its rigid bodies, then its points.

    stays : (runs,) which
    scene : of one of them
    """
    rigid = sum(not (body.fixed or body.is_point) for body in scene.bodies)
    points = sum(body.is_point for body in scene.bodies)
    runs = len(stays)
    numbers = np.frombuffer(state, dtype='<f8')
    sizes = (
        runs * rigid * STATE_OF_POINT,
        runs * points * STATE_OF_POINT,
        runs * rigid * STATE_OF_TURN,
    )
    assert sum(sizes) == len(numbers), 'a pack remembers nothing else'
    parts = np.split(numbers, np.cumsum(sizes)[:-1])
    return b''.join(part.reshape(runs, -1)[stays].tobytes() for part in parts if part.size)


def runs_in_packs(
    keys: Sequence[Hashable | None], scenes: Sequence[Scene]
) -> tuple[list[list[int]], list[int]]:
    """
    Part runs, by their place in the lists, into packs and those that go alone.
    """
    groups: dict[Hashable, list[int]] = {}
    alone = []
    for place, key in enumerate(keys):
        if key is None:
            alone.append(place)
        else:
            groups.setdefault(key, []).append(place)
    packs = []
    for group in groups.values():
        most = most_in_a_pack(scenes[group[0]])
        count = math.ceil(len(group) / most)
        packs += [group[len(group) * i // count : len(group) * (i + 1) // count]
                  for i in range(count)]  # fmt: skip
    return packs, alone
