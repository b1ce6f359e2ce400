# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Poses that a scene names and that stay: where each body starts, and the frames of fixed bodies.
"""

from __future__ import annotations

from dataclasses import dataclass

from rigid_body_sim.physics.model import rotation as so3
from rigid_body_sim.physics.model.named_frames import full_name
from rigid_body_sim.physics.model.scene import Body, Quaternion, Scene, Vector
from rigid_body_sim.physics.state.snapshot import State


@dataclass(frozen=True)
class NamedPose:
    """
    A pose in the world.

    position    : (3,) [m]
    orientation : (4,) [-]  unit quaternion xyzw, its axes to the world
    """

    name: str
    description: str
    tags: tuple[str, ...]
    position: Vector
    orientation: Quaternion


def named_poses(scene: Scene, start: State) -> list[NamedPose]:
    """
    Give the start of every body under its name, and frames of fixed ones: `<body>/<frame>`.

    start : of the bodies when the scene begins
    """
    poses = []
    for body, position, orientation in zip(
        scene.bodies, start.position, start.orientation, strict=True
    ):
        x, y, z = position.tolist()
        i, j, k, w = orientation.tolist()
        said = f'where the scene starts {body.name!r}'
        poses.append(NamedPose(body.name, said, ('start',), (x, y, z), (i, j, k, w)))
        if body.fixed:
            poses += _frames(body)
    return poses


def _frames(body: Body) -> list[NamedPose]:
    """Place the frames of a fixed body in the world."""
    poses = []
    for name, frame in body.frames.items():
        moved = so3.rotate(body.initial.orientation, frame.position)
        x, y, z = (moved + body.initial.position).tolist()
        i, j, k, w = so3.multiply(body.initial.orientation, frame.orientation).tolist()
        poses.append(
            NamedPose(
                full_name(body, name),
                f'the frame {name!r} of the fixed body {body.name!r}',
                ('frame',),
                (x, y, z),
                (i, j, k, w),
            )
        )
    return poses
