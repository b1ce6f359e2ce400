# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Convex decomposition: what a mesh that is not convex collides as, where a scene asks for it.

    shape: {type: mesh, file: cup.stl, as: parts, concavity: 0.03}

CoACD (Wei, Liu, Ling & Su, Approximate convex decomposition for 3D meshes with collision-aware
concavity and tree search, SIGGRAPH 2022; MIT licence; the Python package `coacd`) cuts the mesh
until no part leaves more than `concavity` of it (of half the longest edge of its box) between
itself and its hull. Mass properties stay those of the mesh.

It takes seconds. The parts are kept under the digest of the mesh and the setting: in the cache
folder, and in the bag of a run, from which they are read again wherever it is replayed.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import tempfile
from pathlib import Path

import numpy as np

from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model.shapes import ConvexHull, Mesh

CONCAVITY = 0.05  # [-] of CoACD, its own default; smaller: more parts
LEAST, MOST = 0.01, 1.0  # [-] that CoACD takes
SEED = 0


def parts_name(path: str, concavity: float) -> str:
    """Name the file of the parts of a mesh beside that of the mesh."""
    return f'{path}.parts_{concavity:g}.json'


def find_parts(mesh: Mesh, concavity: float) -> bytes:
    """Return the parts of a mesh as a file: out of the cache, or found and put there."""
    places = _cache_files(mesh, concavity)
    for kept in places:
        with contextlib.suppress(OSError, ValueError, InvalidModel):
            text = kept.read_bytes()
            read_parts(text, name=str(kept))
            return text
    text = _decomposed(mesh, concavity)
    for kept in places:
        with contextlib.suppress(OSError):
            _write(kept, text)
            break
    return text


def read_parts(text: bytes, *, name: str) -> tuple[ConvexHull, ...]:
    """Read what `find_parts` gave."""
    try:
        parts = [np.array(part, dtype=np.float64) for part in json.loads(text)['parts']]
    except (ValueError, TypeError, KeyError, RecursionError) as error:
        raise InvalidModel(f'{name!r} holds no parts of a mesh; remove it') from error
    if not parts:
        raise InvalidModel(f'{name!r} holds no parts of a mesh; remove it')
    return tuple(ConvexHull(part) for part in parts)


def _decomposed(mesh: Mesh, concavity: float) -> bytes:
    import coacd  # type: ignore[import-not-found]  # optional: asked for by the scene

    coacd.set_log_level('error')
    found = coacd.run_coacd(
        coacd.Mesh(mesh.vertices, mesh.faces.astype(np.int32)), threshold=concavity, seed=SEED
    )
    parts = [np.asarray(vertices, dtype=np.float64).tolist() for vertices, _ in found]
    if not parts:
        raise InvalidModel(
            f'mesh {mesh.name!r}: CoACD finds no convex parts; a closed surface of triangles is '
            'needed'
        )
    return json.dumps({'concavity': concavity, 'parts': parts}).encode()


def _cache_files(mesh: Mesh, concavity: float) -> list[Path]:
    """Where the parts of a mesh may be kept: in the first place that can be written."""
    environment = os.environ
    shared = environment.get('XDG_CACHE_HOME', '')
    folders = [
        environment.get('RIGID_BODY_SIM_CACHE'),
        Path(shared).is_absolute() and f'{shared}/rigid_body_sim',  # else it counts as not set
        environment.get('HOME', '') and f'{environment["HOME"]}/.cache/rigid_body_sim',
    ]
    digest = hashlib.sha256(mesh.vertices.tobytes())
    digest.update(mesh.faces.tobytes())
    digest.update(f'{concavity!r} {SEED}'.encode())
    name = f'{digest.hexdigest()}.json'
    return [Path(folder) / 'parts' / name for folder in folders if folder]


def _write(path: Path, text: bytes) -> None:
    """Write a file that is there whole or not at all."""
    path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    with tempfile.NamedTemporaryFile(dir=path.parent, delete=False) as file:
        file.write(text)
    Path(file.name).replace(path)
