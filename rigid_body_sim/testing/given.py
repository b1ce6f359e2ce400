# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What a test asks for, written to files that the node reads: a scene, and parameters.

A file of parameters says what type each has; a word on the command line would be guessed at.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path, PurePosixPath
from typing import Any, NamedTuple

import yaml

from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.scene import load_scene
from rigid_body_sim.scene.shipped_scenes import find_scene
from rigid_body_sim.testing.failures import NodeFailure


class GivenScene(NamedTuple):
    """
    A scene that a node can be started with.

    path   : absolute
    bodies : names, in its order
    dt_ns  : [ns]
    """

    path: Path
    bodies: tuple[str, ...]
    dt_ns: int


def scene_file(asked: Any, folder: Path) -> GivenScene:
    """
    Find the file of a scene, or write it; NodeFailure, with the refusal, for what is none.

    asked  : name of a shipped scene, path, or mapping with the keys of the YAML; files that a
             mapping names are read from the current folder
    folder : where to write
    """
    try:
        if isinstance(asked, Mapping):
            scene = load_scene(asked)
            path = folder / 'scene.yaml'
            path.write_bytes(scene.source)
            _copy(scene.files, folder)
        else:
            path = find_scene(asked).resolve()
            scene = load_scene(path)
    except (UserError, InvalidModel) as error:
        raise NodeFailure(str(error)) from None
    return GivenScene(path, tuple(body.name for body in scene.bodies), scene.dt_ns)


def _copy(files: Mapping[str, bytes], folder: Path) -> None:
    """Put the files that a scene names beside it."""
    for name, content in files.items():
        relative = PurePosixPath(name)
        if not relative.is_absolute() and '..' not in relative.parts and ':' not in name:
            target = folder / relative
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(content)


def parameter_file(parameters: Mapping[str, Any], folder: Path) -> Path:
    """
    Write parameters; NodeFailure for one that the node does not have or that ROS cannot hold.

    A whole number becomes a double where the node has one: ROS tells the two from each other.
    """
    from rigid_body_sim.ros.parameters import PARAMETERS, strangers

    if unknown := strangers(list(parameters)):
        raise NodeFailure('; '.join(unknown))
    doubles = {entry.name for entry in PARAMETERS if isinstance(entry.default, float)}
    values = {name: _plain(name, value) for name, value in parameters.items()}
    for name in doubles & values.keys():
        if isinstance(values[name], int) and not isinstance(values[name], bool):
            values[name] = float(values[name])
    content = {'/**': {'ros__parameters': values}}
    path = folder / 'parameters.yaml'
    path.write_text(yaml.safe_dump(content, allow_unicode=True), encoding='utf-8')
    return path


def _plain(name: str, value: Any) -> Any:
    """Give what YAML writes for a value, be it of numpy or a path."""
    if isinstance(value, Path):
        return str(value)
    value = value.tolist() if hasattr(value, 'tolist') else value
    if isinstance(value, list | tuple):
        return [_plain(name, item) for item in value]
    if not isinstance(value, bool | int | float | str):
        raise NodeFailure(
            f'parameter {name}: got {type(value).__name__}; allowed: true or false, a number, a '
            'text, or a list of one of them'
        )
    return value
