# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Read the `shape` of a body: one small reader for each type."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from rigid_body_sim.physics.model import rotation
from rigid_body_sim.physics.model.height_field import height_field
from rigid_body_sim.physics.model.shapes import (
    Box,
    Capsule,
    ConvexHull,
    Cylinder,
    Mesh,
    Part,
    Particle,
    Particles,
    Plane,
    Shape,
    Sphere,
    Surface,
    Union,
)
from rigid_body_sim.scene.convex_parts import CONCAVITY, LEAST, MOST
from rigid_body_sim.scene.files import Files
from rigid_body_sim.scene.grammar import PART_KEYS, POINT_MASS, SHAPES
from rigid_body_sim.scene.values import Value

COLLIDES_AS = SHAPES['mesh'].keys['as'].kind.choices


def read_shape(value: Value, files: Files) -> Shape:
    """Return the shape that a mapping with a `type` describes."""
    value.need_mapping('a mapping such as {type: sphere, radius: 0.1}')
    kind = value.at('type', what=f'one of {", ".join(KINDS)}').choice(KINDS, what='shape')
    value.need_known(('type', *SHAPES[kind].keys))
    with value.blamed():
        return KINDS[kind](value, files)


def _length(value: Value, key: str) -> float:
    return value.at(key, what='a length [m]').number(unit='m')


def _particle(value: Value, files: Files) -> Particle:
    return Particle()


def _sphere(value: Value, files: Files) -> Sphere:
    return Sphere(_length(value, 'radius'))


def _box(value: Value, files: Files) -> Box:
    return Box(value.at('size', what='a list of three edge lengths [m]').vector(unit='m'))


def _cylinder(value: Value, files: Files) -> Cylinder:
    return Cylinder(_length(value, 'radius'), _length(value, 'length'))


def _capsule(value: Value, files: Files) -> Capsule:
    return Capsule(_length(value, 'radius'), _length(value, 'length'))


def _convex_hull(value: Value, files: Files) -> ConvexHull:
    vertices = value.at('vertices', what='a list of points [m]')
    points = [item.vector(unit='m') for item in vertices.items('a list of points [m]')]
    return ConvexHull(np.array(points).reshape(-1, 3))


def _mesh(value: Value, files: Files) -> Mesh | Surface:
    file = value.at('file', what='the path of a mesh, taken from the scene file,')
    kind = value.find('as')
    collides_as = 'hull' if kind is None else kind.choice(COLLIDES_AS, what='surface')
    concavity = value.find('concavity')
    if concavity is not None and collides_as != 'parts':
        raise concavity.error('it says how near convex parts come; set as: parts, or remove it')
    how_near = (
        CONCAVITY if concavity is None else concavity.number(unit='-', minimum=LEAST, maximum=MOST)
    )
    with file.blamed():
        path = file.text('the path of a mesh')
        if collides_as == 'parts':
            return files.mesh_of_parts(path, how_near)
        return files.surface(path) if collides_as == 'triangles' else files.mesh(path)


def _heightfield(value: Value, files: Files) -> Surface:
    """Heights over a grid as ground, of a body that is fixed."""
    spacing = value.at('spacing', what='the distance of two points [m], or one along x and y')
    origin = value.find('origin')
    start = (0.0, 0.0, 0.0) if origin is None else origin.vector(unit='m')
    between = (
        tuple(item.number(unit='m') for item in spacing.items('two distances [m]'))
        if isinstance(spacing.content, list)
        else spacing.number(unit='m')
    )
    file, heights = value.find('file'), value.find('heights')
    if file is not None and heights is not None:
        raise heights.error('give either heights or file, and not both')
    if file is not None:
        with file.blamed():
            path = file.text('the path of a table of heights')
            grid, name = files.heights(path), path
    else:
        heights = value.at('heights', what='rows of heights [m], or file, the path of a table,')
        rows = [row.items('a row of heights [m]') for row in heights.items('rows of heights [m]')]
        grid, name = [[height.number(unit='m') for height in row] for row in rows], 'height field'
    return height_field(grid, spacing=between, origin=start, name=name)


def _particles(value: Value, files: Files) -> Particles:
    what = 'a list of {mass: kg, position: [m, m, m]}'
    positions, masses = [], []
    for item in value.at('particles', what=what).items(what):
        item.need_mapping('{mass: kg, position: [m, m, m]}')
        item.need_known(POINT_MASS.keys)
        masses.append(item.at('mass', what='a mass [kg]').number(unit='kg', positive=True))
        positions.append(item.at('position', what='a list of three numbers [m]').vector(unit='m'))
    return Particles(np.array(positions).reshape(-1, 3), np.array(masses))


def _plane(value: Value, files: Files) -> Plane:
    normal = value.at('normal', what='a list of three numbers [-], out of the solid,').vector(
        unit='-'
    )
    offset = value.find('offset')
    return Plane(normal, 0.0 if offset is None else offset.number(unit='m'))


def _union(value: Value, files: Files) -> Union:
    what = 'a list of at least one {shape: …, mass: kg, position: [m, m, m]}'
    return Union(tuple(_part(item, files) for item in value.at('parts', what=what).items(what)))


def _part(value: Value, files: Files) -> Part:
    value.need_mapping('{shape: …, mass: kg, position: [m, m, m]}')
    value.need_known(PART_KEYS)
    mass, density, position, orientation = (
        value.find(key) for key in ('mass', 'density', 'position', 'orientation')
    )
    shape = read_shape(value.at('shape', what='a mapping with a type'), files)
    with value.blamed():
        return Part(
            shape,
            mass=None if mass is None else mass.number(unit='kg', positive=True),
            density=None if density is None else density.number(unit='kg/m^3', positive=True),
            position=(0.0, 0.0, 0.0) if position is None else position.vector(unit='m'),
            orientation=rotation.IDENTITY if orientation is None else orientation.quaternion(),
        )


KINDS: dict[str, Callable[[Value, Files], Shape]] = {
    'particle': _particle,
    'sphere': _sphere,
    'box': _box,
    'cylinder': _cylinder,
    'capsule': _capsule,
    'convex_hull': _convex_hull,
    'mesh': _mesh,
    'heightfield': _heightfield,
    'particles': _particles,
    'plane': _plane,
    'union': _union,
}
