# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What physics refuses when a run of a scene is made, told with file, place and line.

Physics names what it blames by its place in the scene it was given (`InvalidModel.at`); where that
stands in the text of the scene is looked up here, by reading the text again. Of a body that
`repeat` made, the one that was repeated is named. What is not in the text (`shape`, where a URDF
file says it) is told at the nearest place that is.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.scene import document
from rigid_body_sim.scene.values import Value


def refusal(
    scene: Scene, error: InvalidModel, parsed: document.Document | None = None
) -> UserError:
    """
    Return what is wrong with a scene, with the place in its text.

    parsed : the text, where somebody holds it parsed
    """
    if parsed is None:
        origin = scene.origin
        parsed = document.read(scene.source, name=origin.name, with_lines=origin.has_lines)
    text = Value(parsed.content, parsed)
    path = error.at
    if path[:1] == ('bodies',):
        name = scene.bodies[int(path[1])].name
        path = ('bodies', _place(name, text.content['bodies']), *path[2:])
    return text.below(path).error(str(error))


def _place(name: str, bodies: Iterable[Mapping[str, Any]]) -> int:
    """Tell which body of the text has a name, or was repeated under it."""
    written = [str(body['name']) for body in bodies]
    return written.index(name if name in written else name.rpartition('_')[0])
