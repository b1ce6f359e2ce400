# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Frames fixed to a body, and what a wrench in one does to the body.

    F_B = R_BF F_F,    T_B = R_BF T_F + p x F_B
        F_F, T_F : [N, N m]  force at the origin of the frame and torque, axes of the frame
        F_B, T_B : [N, N m]  force at the centre of mass and torque about it, body axes
        p, R_BF  : [m, -]    origin of the frame as seen from the centre of mass, its attitude

The same holds for impulses. This is the wrench that tf2 gives when it moves one from the frame
`<body>/<frame>` to the frame `<body>`, whose origin is the centre of mass.

Source: Featherstone, Rigid Body Dynamics Algorithms (2008), section 2.8.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import Any

import numpy as np

from rigid_body_sim.physics.errors import InvalidModel, blaming, choose_from
from rigid_body_sim.physics.model import rotation as so3
from rigid_body_sim.physics.model.numbers import shown
from rigid_body_sim.physics.model.scene import Body, Frame, Vector

RESERVED_FRAMES = ('world', 'body')  # what else the frame of a command may be called
SEPARATOR = '/'


def full_name(body: Body, frame: str) -> str:
    """Name a frame of a body as the other frames of a scene see it: `<body>/<frame>`."""
    return f'{body.name}{SEPARATOR}{frame}'


def frame_names(body: Body) -> list[str]:
    """Every name by which a command may mean a frame of a body: its own, and of its frames."""
    full = [full_name(body, frame) for frame in body.frames]
    return [body.name, *full, *body.frames]


def check_frame_names(body: Body, bodies: Collection[str]) -> None:
    """Refuse names of frames that a command could take for something else."""
    for name in body.frames:
        with blaming(name):
            if name in RESERVED_FRAMES:
                raise InvalidModel(
                    f'{name!r} means other axes in a command ({", ".join(RESERVED_FRAMES)}); '
                    'choose another name'
                )
            if name in bodies:
                raise InvalidModel(
                    f'{name!r} is the name of a body, whose axes a command would mean by it; '
                    'choose another name'
                )


def own_name(body: Body, name: str) -> str:
    """Give `<frame>` for `<body>/<frame>`, and what is no full name as it is."""
    return name if name in body.frames else name.removeprefix(body.name + SEPARATOR)


def find_frame(body: Body, name: str) -> Frame | None:
    """Find a frame of a body by `<frame>` or `<body>/<frame>`; None where it has none of it."""
    return body.frames.get(own_name(body, name))


def frame_of(body: Body, name: object) -> str:
    """
    Find the frame in which a command to a body is given: 'world', 'body', or the name of its own.

    Raises InvalidModel for anything else.
    """
    if isinstance(name, str):
        own = name if name in RESERVED_FRAMES else own_name(body, name)
        if own in RESERVED_FRAMES or own in body.frames:
            return own
    raise InvalidModel(
        f'command to {body.name!r}: frame {shown(name)}'
        f'{choose_from(name, [*RESERVED_FRAMES, *body.frames])}'
    )


def at_center(frame: Frame, force: Any, torque: Any) -> tuple[Vector, Vector]:
    """
    Move a wrench, or an impulse, from a frame to the centre of mass, body axes.

    Raises InvalidModel where it leaves the numbers there.
    """
    with np.errstate(over='ignore', invalid='ignore'):
        f = so3.rotate(frame.orientation, force)
        t = so3.rotate(frame.orientation, torque) + np.cross(frame.position, f)
    values = [*f.tolist(), *t.tolist()]
    if not all(map(math.isfinite, values)):
        raise InvalidModel(
            'moved to the centre of mass it is beyond the largest number; check the units (m, N)'
        )
    f_x, f_y, f_z, t_x, t_y, t_z = values
    return (f_x, f_y, f_z), (t_x, t_y, t_z)
