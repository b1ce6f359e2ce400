# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Where a scene is: a path, or the bare name of a scene that comes with the package.

Shipped scenes lie in `config/scenes` of the tree that the code runs from, or, installed, in
`share/rigid_body_sim/config/scenes` of a ROS workspace (AMENT_PREFIX_PATH) or of the Python
environment.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.errors import choose_from
from rigid_body_sim.scene import regular_file

LONGEST = 200  # [-] letters of what was asked for that a message shows
SCHEMA = 'scene.schema.json'
_FOLDER = Path('config') / 'scenes'


def find_scene(asked: str | os.PathLike[str]) -> Path:
    """
    Return the path of a scene file; UserError, which names the shipped scenes, if there is none.

    asked : a path, or the name of a shipped scene with or without `.yaml`
    """
    path = Path(asked)
    if regular_file.exists(path):
        return path
    shipped = shipped_scenes()
    is_bare = path.name == str(asked)
    name = path.name.removesuffix('.yaml')
    if is_bare and name in shipped:
        return shipped[name]
    word = f'{str(asked)[:LONGEST]!r}…' if len(str(asked)) > LONGEST else repr(str(asked))
    near = choose_from(name if is_bare else None, sorted(shipped)).removeprefix('; ')
    raise UserError(
        f'scene {word}: no such file; give the path of a scene file (YAML), or the name of a '
        f'shipped scene; {near}'
    )


def shipped_scenes() -> dict[str, Path]:
    """Name -> path of every shipped scene."""
    found: dict[str, Path] = {}
    for folder in _folders():
        for path in sorted(folder.glob('*.yaml')):
            found.setdefault(path.stem, path)
    return found


def schema_path() -> Path:
    """
    Return the path of the JSON Schema of scenes, which editors read; UserError if it is missing.
    """
    for folder in _folders():
        path = folder.parent / SCHEMA
        if path.is_file():
            return path
    raise UserError(f'{SCHEMA}: it is not installed; install the package anew')


def _folders() -> list[Path]:
    share = Path('share') / 'rigid_body_sim' / _FOLDER
    workspaces = os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep)
    return [
        Path(__file__).parents[2] / _FOLDER,
        *(Path(workspace) / share for workspace in workspaces if workspace),
        Path(sys.prefix) / share,
    ]
