# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The further files a scene names: URDF files and meshes.

They are kept byte for byte, so that a recording holds the whole experiment. They come either from
the folder of the scene, or from given bytes: then the disk is not touched. `package://NAME/PATH`
is looked for in a folder NAME at or above the scene, then in `share/NAME` of the ROS workspaces
(AMENT_PREFIX_PATH) and of the Python environment.
"""

from __future__ import annotations

import io
import os
import re
import sys
import warnings
from codecs import BOM_UTF8
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model.shapes import Mesh, Surface
from rigid_body_sim.scene import regular_file
from rigid_body_sim.scene.convex_parts import find_parts, parts_name, read_parts

PACKAGE = 'package://'
MESH_FORMATS = ('off', 'stl', 'obj', 'ply')
STL_HEAD, STL_TRIANGLE = 84, 50  # [byte] of binary STL: a title and the count, one triangle
STL_END = 10_000  # [byte] in which the last word of STL as text stands
STL_WORDS = re.compile(rb'(?im)^\s*(endsolid|facet|outer|vertex|endloop|endfacet)\b')
COUNTS = 3  # [-] numbers that OFF begins with: of vertices, faces and edges
QUAD = 4  # [corners] of the largest polygon that trimesh cuts in every format
TABLE_FORMATS = ('csv', 'txt', 'npy')


class Files:
    """
    Bytes by the name written in the scene.

    folder : where relative names are looked up
    given  : the bytes themselves; None means they are read from the folder
    """

    def __init__(self, *, folder: Path, given: Mapping[str, bytes] | None) -> None:
        self._folder = folder
        self._given = given
        self.used: dict[str, bytes] = {}
        self._meshes: dict[tuple[str | float, ...], Mesh] = {}
        self._surfaces: dict[str, Surface] = {}

    def read(self, name: str) -> bytes:
        """Return the bytes of a file and remember them in `used`."""
        if name not in self.used:
            self.used[name] = (
                self._given_bytes(name) if self._given is not None else self._disk_bytes(name)
            )
        return self.used[name]

    def mesh(
        self, path: str, *, name: str | None = None, scale: tuple[float, ...] = (1.0, 1.0, 1.0)
    ) -> Mesh:
        """
        Return the mesh of a file: the same one whenever it is asked for, its hull is found once.

        name  : what messages call it; None: its path
        scale : (3,) [-] along its axes; a mirror image turns its triangles, to keep their outside
                out
        """
        key = (path, name or path, *scale)
        if key not in self._meshes:
            if scale == (1.0, 1.0, 1.0):
                self._meshes[key] = mesh_from_bytes(self.read(path), name=name or path)
            else:
                plain = self.mesh(path, name=name)
                mirrored = np.prod(scale) < 0.0
                faces = plain.faces[:, ::-1] if mirrored else plain.faces
                self._meshes[key] = Mesh(plain.vertices * scale, faces, plain.name)
        return self._meshes[key]

    def mesh_of_parts(self, path: str, concavity: float) -> Mesh:
        """Return the mesh of a file that collides as convex parts: see `convex_parts`."""
        key = (path, 'parts', concavity)
        if key not in self._meshes:
            mesh, name = self.mesh(path), parts_name(path, concavity)
            if self._given is not None and name in self._given:
                text = self.read(name)
            else:
                text = self.used[name] = find_parts(mesh, concavity)
            parts = read_parts(text, name=name)
            self._meshes[key] = Mesh(mesh.vertices, mesh.faces, mesh.name, parts)
        return self._meshes[key]

    def surface(self, path: str) -> Surface:
        """Return the triangles of a mesh as ground: the same surface whenever it is asked for."""
        if path not in self._surfaces:
            vertices, faces = triangles_from_bytes(self.read(path), name=path)
            self._surfaces[path] = Surface(vertices, faces, path)
        return self._surfaces[path]

    def heights(self, path: str) -> np.ndarray:
        """Return the table of heights of a file."""
        return table_from_bytes(self.read(path), name=path)

    def _given_bytes(self, name: str) -> bytes:
        assert self._given is not None
        if name not in self._given:
            known = ', '.join(self._given) or 'none'
            raise InvalidModel(
                f'{name!r} is not among the given files ({known}); a recording must hold it'
            )
        return bytes(self._given[name])

    def _disk_bytes(self, name: str) -> bytes:
        try:
            return regular_file.read(self._path(name))
        except (OSError, ValueError) as error:
            raise InvalidModel(
                f'{name!r} cannot be read: {regular_file.reason(error)}; the path is taken '
                'from the scene file'
            ) from error

    def _path(self, name: str) -> Path:
        if not name.startswith(PACKAGE):
            return self._folder / name
        package, _, rest = name.removeprefix(PACKAGE).partition('/')
        places = _package_folders(package, self._folder)
        for place in places:
            if (place / rest).is_file():
                return place / rest
        raise InvalidModel(
            f'{name!r} is not found; looked in: {", ".join(map(str, places))}; put the package '
            'beside the scene, or source its workspace'
        )


def _package_folders(package: str, folder: Path) -> list[Path]:
    """Where a ROS package may lie."""
    here = folder.absolute()
    above = [place / package for place in (here, *here.parents) if (place / package).is_dir()]
    itself = [place for place in (here, *here.parents) if place.name == package]
    workspaces = os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep)
    shares = [Path(place) / 'share' / package for place in (*workspaces, sys.prefix) if place]
    return [*itself, *above, *shares]


def table_from_bytes(text: bytes, *, name: str) -> np.ndarray:
    """Read a matrix of numbers: rows of CSV or of plain text, or an array of NumPy."""
    kind = Path(name).suffix.lower().lstrip('.')
    if kind not in TABLE_FORMATS:
        raise InvalidModel(
            f'{name!r} has no known format of a table; allowed endings: '
            f'{", ".join(TABLE_FORMATS)}; an image can be saved as one of them by NumPy'
        )
    text = text.removeprefix(BOM_UTF8)
    if not text.strip():
        raise InvalidModel(f'{name!r} is empty; give a table of numbers, row by row')
    try:
        if kind == 'npy':
            return _real(np.load(io.BytesIO(text), allow_pickle=False))
        delimiter = ',' if kind == 'csv' else None
        with warnings.catch_warnings():
            warnings.simplefilter('error', UserWarning)  # of comments alone
            return np.loadtxt(io.BytesIO(text), delimiter=delimiter, ndmin=2)
    except (ValueError, EOFError, OSError, UserWarning) as error:
        reason = ' '.join(str(error).split()).rstrip('.!') or type(error).__name__
        if isinstance(error, UserWarning):
            reason = 'it holds comments and no numbers'
        raise InvalidModel(
            f'{name!r} is not readable as {kind.upper()}: {reason}; give a table of this format, '
            f'or the ending of another: {", ".join(TABLE_FORMATS)}'
        ) from error


def _real(table: Any) -> np.ndarray:
    """Give an array back; ValueError unless it is one, of real numbers."""
    if not isinstance(table, np.ndarray):
        raise ValueError('it is an archive of arrays; allowed: one array')
    if not (np.issubdtype(table.dtype, np.floating) or np.issubdtype(table.dtype, np.integer)):
        raise ValueError(f'its elements are {table.dtype}; allowed: integers, floats')
    return table


def mesh_from_bytes(text: bytes, *, name: str) -> Mesh:
    """Read the solid inside a triangle mesh."""
    return Mesh(*triangles_from_bytes(text, name=name), name)


def triangles_from_bytes(text: bytes, *, name: str) -> tuple[np.ndarray, np.ndarray]:
    """
    Read the vertices (n, 3) and faces (m, 3) of a triangle mesh through trimesh, which is imported
    only here.

    Corners with the same coordinates become one vertex (STL stores each triangle apart), so that
    open edges show.
    """
    kind = Path(name).suffix.lower().lstrip('.')
    if kind not in MESH_FORMATS:
        raise InvalidModel(
            f'{name!r} has no known mesh format; allowed endings: {", ".join(MESH_FORMATS)}'
        )
    if not text.strip():
        raise InvalidModel(f'{name!r} is empty; a mesh is a closed surface of triangles')
    if kind == 'off':
        text = _off_line_by_line(text)
    _need_whole(text, kind, name)
    import trimesh

    if kind == 'off':
        text = _off_of_triangles(text)
    try:
        loaded = trimesh.load_mesh(io.BytesIO(text), file_type=kind, process=False)
        vertices = np.asarray(loaded.vertices, dtype=np.float64)
        faces = np.asarray(loaded.faces, dtype=np.int64)
        vertices, index = np.unique(vertices, axis=0, return_inverse=True)
        faces = index.reshape(-1)[faces]
    except (
        Exception
    ) as error:  # the parsers of trimesh raise whatever their text made them stumble over
        reason = ' '.join(str(error).split()).rstrip('.!') or type(error).__name__
        raise InvalidModel(
            f'{name!r} is not readable as {kind.upper()}: {reason}; give a mesh of this format, '
            f'or the ending of another: {", ".join(MESH_FORMATS)}'
        ) from error
    if not len(faces):
        raise InvalidModel(
            f'{name!r} holds no triangles, read as {kind.upper()}; a mesh is a closed surface of '
            f'triangles, in the format of its ending: {", ".join(MESH_FORMATS)}'
        )
    return vertices, faces


def _need_whole(text: bytes, kind: str, name: str) -> None:
    """Refuse a mesh that has less, or other, than it says itself."""
    wrong = {'stl': _stl_fault, 'off': _off_fault, 'ply': _ply_fault}.get(kind, lambda _text: None)
    fault = wrong(text)
    if fault is not None:
        raise InvalidModel(
            f'{name!r}, read as {kind.upper()}, {fault}; write or copy it anew, or give it the '
            f'ending of another format: {", ".join(MESH_FORMATS)}'
        )


def _stl_fault(text: bytes) -> str | None:
    """Say what is wrong with the length of STL; None: it fits, or it is something else."""
    count = int.from_bytes(text[STL_HEAD - 4 : STL_HEAD], 'little')
    needed = STL_HEAD + STL_TRIANGLE * count
    if len(text) == needed:
        return None
    if text.lstrip().lower().startswith(b'solid'):
        words = STL_WORDS.findall(text[-STL_END:])
        if words:
            is_whole = words[-1].lower() == b'endsolid'
            return None if is_whole else "is cut short: text without 'endsolid' at its end"
    if len(text) < STL_HEAD or needed > regular_file.MOST:  # so many are some other text
        return None
    what = 'is cut short' if len(text) < needed else 'has bytes behind its triangles'
    return (
        f'{what}: it counts {count} triangles and has {len(text)} bytes; allowed: '
        f'{STL_HEAD} + {STL_TRIANGLE} * {count} = {needed} bytes'
    )


def _off_fault(text: bytes) -> str | None:
    """Say that OFF lacks its keyword, or has less than its counts; None: neither."""
    if not any(b'OFF' in line.split(b'#')[0] for line in text.splitlines()):
        return 'lacks the keyword OFF, in capitals, which is to be its first word'
    counts, lines = _off_lines(text)
    return _fault_of_lines([b'vertices', b'faces'], counts, lines)


def _off_line_by_line(text: bytes) -> bytes:
    """
    Write each vertex and each face of OFF on a line of its own, as trimesh wants them: the format
    itself parts them by blanks of any kind. What has such lines, or not all words, stays.
    """
    lines = [line.split(b'#')[0].split() for line in text.splitlines()]
    first, *words = [word for line in lines for word in line] or [b'']
    if first != b'OFF' or not all(word.isdigit() for word in words[:COUNTS]):
        return text
    vertices, faces = map(int, (words + [b'0', b'0'])[:2])
    if sum(len(line) >= 3 for line in lines) > vertices + faces:  # one of them has the counts
        return text
    if len(words) < COUNTS + 3 * vertices + faces:
        return text
    end = COUNTS + 3 * vertices
    found = [words[:COUNTS], *(words[i : i + 3] for i in range(COUNTS, end, 3))]
    for _ in range(faces):
        if end >= len(words) or not words[end].isdigit():
            return text
        begin, end = end, end + 1 + int(words[end])
        found.append(words[begin:end])
    if end != len(words):
        return text
    return b'\n'.join([first, *map(b' '.join, found)])


def _off_lines(text: bytes) -> tuple[list[bytes], list[list[bytes]]]:
    """Part OFF into its counts, of vertices and faces, and the words of the lines after them."""
    lines = [line.split(b'#')[0].split() for line in text.splitlines()]
    head, *rest = [line for line in lines if line] or [[]]
    counts = head[1:]
    if not counts and rest:
        counts, *rest = rest
    return counts[:2], rest


def _off_of_triangles(text: bytes) -> bytes:
    """
    Cut the polygons of OFF that have more than four corners into fans of triangles, as trimesh
    does with those of OBJ and PLY: of OFF it cannot, since NumPy 2.5.
    """
    counts, lines = _off_lines(text)
    if b'OFF' not in text or len(counts) < 2 or not all(count.isdigit() for count in counts):
        return text
    vertices, faces = map(int, counts)
    points, polygons = lines[:vertices], lines[vertices : vertices + faces]
    if not all(face[0].isdigit() and int(face[0]) < len(face) for face in polygons):
        return text
    if not any(int(face[0]) > QUAD for face in polygons):
        return text
    triangles = [
        [b'3', corners[0], *corners[i : i + 2]]
        for count, *corners in polygons
        for i in range(1, int(count) - 1)
    ]
    head = [[b'OFF'], [b'%d' % vertices, b'%d' % len(triangles), b'0']]
    return b'\n'.join(b' '.join(words) for words in (*head, *points, *triangles))


def _ply_fault(text: bytes) -> str | None:
    """Say that PLY as text has less elements than its counts; None: it does not."""
    head, end, rest = text.partition(b'end_header')
    lines = [line.split() for line in head.splitlines()]
    if not end or [b'format', b'ascii'] not in [line[:2] for line in lines]:
        return None  # binary: trimesh says so
    counted = [line for line in lines if line[:1] == [b'element'] and len(line) == 3]
    names = [{b'vertex': b'vertices', b'face': b'faces'}.get(line[1], line[1]) for line in counted]
    there = [line.split() for line in rest.splitlines() if line.strip()]
    return _fault_of_lines(names, [line[2] for line in counted], there)


def _fault_of_lines(
    names: list[bytes], counts: list[bytes], lines: list[list[bytes]]
) -> str | None:
    """
    Say that there are less lines than are counted, or that the last one, a face, lacks corners;
    None: all is there, or the counts are no numbers.
    """
    if len(names) != len(counts) or not all(count.isdigit() for count in counts):
        return None
    needed = sum(map(int, counts))
    if len(lines) < needed:
        told = ' and '.join(
            f'{int(count)} {what.decode(errors="replace")}'
            for what, count in zip(names, counts, strict=True)
        )
        return (
            f'is cut short: it counts {told}, a line each, and has {len(lines)} lines of them; '
            f'allowed: {needed} lines or more'
        )
    if not needed or names[-1] != b'faces' or not lines[needed - 1][0].isdigit():
        return None
    corners, there = int(lines[needed - 1][0]), len(lines[needed - 1]) - 1
    if there >= corners:
        return None
    return (
        f'is cut short: its last face counts {corners} corners and has {there}; allowed: all of '
        'them'
    )
