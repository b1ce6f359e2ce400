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

_FOLDER = Path('config') / 'scenes'


def find_scene(asked: str | os.PathLike[str]) -> Path:
    """
    Return the path of a scene file; UserError, which names the shipped scenes, if there is none.

    asked : a path, or the name of a shipped scene with or without `.yaml`
    """
    path = Path(asked)
    if path.exists():
        return path
    shipped = shipped_scenes()
    if path.name == str(asked) and path.name.removesuffix('.yaml') in shipped:
        return shipped[path.name.removesuffix('.yaml')]
    names = ', '.join(sorted(shipped)) or 'none was found'
    raise UserError(
        f'scene {str(asked)!r}: no such file; give the path of a scene file (YAML), '
        f'or the name of a shipped scene: {names}'
    )


def shipped_scenes() -> dict[str, Path]:
    """Name -> path of every shipped scene."""
    found: dict[str, Path] = {}
    for folder in _folders():
        for path in sorted(folder.glob('*.yaml')):
            found.setdefault(path.stem, path)
    return found


def _folders() -> list[Path]:
    share = Path('share') / 'rigid_body_sim' / _FOLDER
    workspaces = os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep)
    return [
        Path(__file__).parents[2] / _FOLDER,
        *(Path(workspace) / share for workspace in workspaces if workspace),
        Path(sys.prefix) / share,
    ]
