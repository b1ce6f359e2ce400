# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Read the one body of a URDF file: mass, centre of mass, inertia tensor, collision shapes.

Body coordinates are those of the link. `<inertial>` is taken as it is written, with its frame
turned and shifted into the link (I_link = R I R^T about the centre of mass), and never computed
from the shape. `<collision>` gives the shape and where it lies; several make a union, in the order
of the file, whose axes are those of the link: each part is placed by its own `<origin>`, and none
by that of `<inertial>`. `<visual>` and `<material>` are not read: they move nothing.

A body is one link. Joints, further links and everything else that would change the motion, here or
in another simulator, is refused by name. The library yourdfpy (extra `urdf`) parses, and is
imported only here; it invents what is missing (a moment of 1 kg m^2, a mass of 0), so the text is
checked before it.
"""

from __future__ import annotations

import io
import math
import posixpath
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model import mass_properties, rotation
from rigid_body_sim.physics.model.plain_products import turned_tensor
from rigid_body_sim.physics.model.scene import Quaternion, Vector
from rigid_body_sim.physics.model.shapes import Box, Cylinder, Mesh, Part, Shape, Sphere, Union
from rigid_body_sim.scene.files import Files
from rigid_body_sim.scene.values import shown

MOMENTS = ('ixx', 'ixy', 'ixz', 'iyy', 'iyz', 'izz')
NUMBERS = {  # attribute of an element: how many numbers it holds
    ('mass', 'value'): (1,),
    **{('inertia', key): (1,) for key in MOMENTS},
    ('origin', 'xyz'): (3,),
    ('origin', 'rpy'): (3,),
    ('box', 'size'): (3,),
    ('cylinder', 'radius'): (1,),
    ('cylinder', 'length'): (1,),
    ('sphere', 'radius'): (1,),
    ('mesh', 'scale'): (1, 3),
}
NEEDED = {
    'robot': ('name',),
    'link': ('name',),
    'mass': ('value',),
    'inertia': MOMENTS,
    'box': ('size',),
    'cylinder': ('radius', 'length'),
    'sphere': ('radius',),
    'mesh': ('filename',),
}
CHILDREN = {  # what an element may hold; None: anything, it is not read
    'robot': ('link', 'material'),
    'link': ('inertial', 'visual', 'collision'),
    'inertial': ('origin', 'mass', 'inertia'),
    'collision': ('origin', 'geometry'),
    'geometry': ('box', 'cylinder', 'sphere', 'mesh'),
    'visual': None,
    'material': None,
}
JOIN = (
    'sum up their <inertial> and make their shapes <collision>s of one link, or join them in '
    'Python as examples/eight_tasks/urdf_of_links.py does'
)
WHY_ONE = {  # elements that stand once in their parent: why, and what to do
    'link': 'a body is one link; give links that move apart files of their own; links on fixed '
    f'joints are one body: {JOIN}',
    'inertial': 'a link has one mass; sum them up',
    'geometry': 'a further shape is a further <collision>',
    **dict.fromkeys(('origin', 'mass', 'inertia'), 'remove what does not count'),
}
WHY_NOT = {
    'joint': f'joints are not supported: a body is one link; of fixed ones: {JOIN}',
    'transmission': 'transmissions are not supported: a body has no motors; remove the element',
    'gazebo': 'settings for another simulator are not read; say friction and restitution in the '
    'scene, and remove the element',
    'capsule': 'capsules are not supported in URDF; describe the body in a scene, or make it a '
    'cylinder and two spheres, a <collision> each',
}
ReadMesh = Callable[[str, tuple[float, ...]], Mesh]  # by the name in the file and its scale
XACRO = 'http://www.ros.org/wiki/xacro'
DIGITS = re.compile(r'[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?', re.ASCII)


@dataclass(frozen=True, eq=False)
class Link:
    """
    What a URDF file says of its body, in link coordinates.

    robot, name       : as written
    mass              : [kg]; None where there is no <inertial>
    center_of_mass    : (3,) [m]
    inertia           : (3, 3) [kg m^2]  about the centre of mass, link axes
    shape             : None where there is no <collision>; a union of several
    shape_position    : (3,) [m]  origin of the shape; zero for a union
    shape_orientation : (4,) [-]  xyzw, shape axes to link axes; 1 for a union
    """

    robot: str
    name: str
    mass: float | None = None
    center_of_mass: Vector = (0.0, 0.0, 0.0)
    inertia: NDArray[np.float64] | None = None
    shape: Shape | None = None
    shape_position: Vector = (0.0, 0.0, 0.0)
    shape_orientation: Quaternion = rotation.IDENTITY


def read_link(files: Files, name: str) -> Link:
    """Read a URDF file and the meshes it names; InvalidModel for what cannot be used."""
    text = files.read(name)
    try:
        return _link(
            text, lambda mesh, scale: files.mesh(_beside(name, mesh), name=mesh, scale=scale)
        )
    except InvalidModel as error:
        raise InvalidModel(f'{name}: {error}') from error


def _link(text: bytes, read: ReadMesh) -> Link:
    try:
        import yourdfpy
        from lxml import etree
    except ImportError as error:
        raise InvalidModel(
            'URDF is read through the library yourdfpy, which is not installed; install it: '
            'pip install yourdfpy'
        ) from error
    try:
        parser = etree.XMLParser(resolve_entities=False, no_network=True)
        root = etree.fromstring(text, parser)
    except (etree.XMLSyntaxError, ValueError) as error:
        raise InvalidModel(f'not readable as XML: {_one_line(error)}') from error
    if root.getroottree().docinfo.doctype:
        raise InvalidModel('a document type is not supported; remove <!DOCTYPE …>')
    _check(root)
    for element in [*root.iter('visual', 'material')]:
        element.getparent().remove(element)
    try:
        text = etree.tostring(root)
        robot = yourdfpy.URDF.load(io.BytesIO(text), build_scene_graph=False).robot
    except Exception as error:  # whatever its parsing stumbled over
        raise InvalidModel(f'not readable as URDF: {_one_line(error)}') from error
    link = robot.links[0]
    found: dict[str, Any] = {}
    if link.inertial is not None:
        with _blamed(next(root.iter('inertial'))):
            found |= _inertial(link.inertial)
    parts = []
    for collision, element in zip(link.collisions, root.iter('collision'), strict=True):
        with _blamed(element):
            parts.append(_part(collision, read))
    if len(parts) == 1:
        (part,) = parts
        found |= {
            'shape': part.shape,
            'shape_position': part.position,
            'shape_orientation': part.orientation,
        }
    elif parts:
        found['shape'] = Union(tuple(parts))
    return Link(robot=robot.name, name=link.name, **found)


@contextmanager
def _blamed(element: Any) -> Iterator[None]:
    """Give the refusals of the physics inside this block the name of this element."""
    try:
        yield
    except InvalidModel as error:
        name = element.get('name')
        named = '' if name is None else f' name={shown(name)}'
        raise InvalidModel(
            f'<{element.tag}{named}> (line {element.sourceline}): {error}'
        ) from error


def _inertial(inertial: Any) -> dict[str, Any]:
    center, turn = _place(inertial.origin)
    inertia = np.array(inertial.inertia)
    if turn != rotation.IDENTITY:
        matrix = rotation.matrix_from_quaternion(np.array(turn))
        inertia = turned_tensor(matrix, inertia)
    if not inertial.mass > 0.0:
        raise InvalidModel(f'<mass> is {inertial.mass!r} kg; it must be positive')
    mass_properties.check_inertia(inertia)
    return {'mass': float(inertial.mass), 'center_of_mass': center, 'inertia': inertia}


def _part(collision: Any, read: ReadMesh) -> Part:
    """Read one collision: a shape and its place in the link."""
    position, orientation = _place(collision.origin)
    return Part(_shape(collision.geometry, read), position=position, orientation=orientation)


def _shape(geometry: Any, read: ReadMesh) -> Shape:
    if geometry.box is not None:
        x, y, z = map(float, geometry.box.size)
        return Box((x, y, z))
    if geometry.cylinder is not None:
        return Cylinder(geometry.cylinder.radius, geometry.cylinder.length)
    if geometry.sphere is not None:
        return Sphere(geometry.sphere.radius)
    return _mesh(geometry.mesh, read)


def _mesh(mesh: Any, read: ReadMesh) -> Mesh:
    scale = tuple((np.ones(3) * (1.0 if mesh.scale is None else mesh.scale)).tolist())
    if not all(scale):
        raise InvalidModel(f'<mesh> scale {scale}; no factor may be zero')
    return read(mesh.filename, scale)


def _place(origin: NDArray[np.float64] | None) -> tuple[Vector, Quaternion]:
    """Split an <origin> into position and orientation."""
    if origin is None:
        return (0.0, 0.0, 0.0), rotation.IDENTITY
    x, y, z = (float(value) for value in origin[:3, 3])
    if np.array_equal(origin[:3, :3], np.eye(3)):
        return (x, y, z), rotation.IDENTITY
    turn = rotation.normalise(rotation.quaternion_from_matrix(origin[:3, :3]))
    i, j, k, w = (float(value) for value in turn)
    return (x, y, z), (i, j, k, w)


def _beside(urdf: str, mesh: str) -> str:
    """
    Name the file of a mesh as the scene would: paths are taken from the URDF file, `package://`
    stays.
    """
    scheme, colon, rest = mesh.partition('://')
    if not colon:
        return posixpath.normpath(posixpath.join(posixpath.dirname(urdf), mesh))
    if scheme == 'file':
        return rest
    if scheme == 'package':
        return mesh
    raise InvalidModel(
        f'<mesh> {mesh!r}: {scheme}:// is not supported; allowed: a path, file://, package://'
    )


def _check(root: Any) -> None:
    """Refuse what is not one whole body: the parser would pass it over, or invent the rest."""
    if root.tag != 'robot':
        raise InvalidModel(f'<{root.tag}> where <robot> should stand: not a URDF file')
    for element in root.iter(f'{{{XACRO}}}*'):
        raise InvalidModel(
            f'xacro (line {element.sourceline}) is not supported; expand the file first: '
            'xacro IN > OUT.urdf'
        )
    for element in _read_elements(root):
        _check_attributes(element)
        _check_children(element)
    if root.find('link') is None:
        raise InvalidModel('<link> is missing')
    for inertial in root.iter('inertial'):
        for tag in ('mass', 'inertia'):
            if inertial.find(tag) is None:
                raise InvalidModel(f'<inertial> has no <{tag}>')
    for collision in root.iter('collision'):
        if len(collision.findall('geometry/*')) != 1:
            raise InvalidModel(
                f'<collision> (line {collision.sourceline}) needs one <geometry> with one shape '
                f'({", ".join(CHILDREN["geometry"])}); a further shape is a further <collision>'
            )


def _read_elements(element: Any) -> Iterator[Any]:
    """Yield an element and what is read below it."""
    yield element
    if CHILDREN.get(element.tag, ()) is not None:
        for child in _elements(element):
            yield from _read_elements(child)


def _elements(element: Any) -> list[Any]:
    return [child for child in element if isinstance(child.tag, str)]  # no comments


def _check_attributes(element: Any) -> None:
    for key in NEEDED.get(element.tag, ()):
        if not element.get(key):
            raise InvalidModel(f'<{element.tag}> (line {element.sourceline}): {key} is missing')
    for key, text in element.items():
        counts = NUMBERS.get((element.tag, key))
        words = text.replace(',', ' ').split() if element.tag in ('box', 'mesh') else text.split()
        if counts is not None and not (len(words) in counts and all(map(_is_number, words))):
            wanted = 'a finite number' if counts == (1,) else f'{counts[-1]} finite numbers'
            raise InvalidModel(
                f'<{element.tag} {key}={shown(text)}> (line {element.sourceline}): '
                f'{"one or " if len(counts) > 1 else ""}{wanted} needed'
            )


def _is_number(word: str) -> bool:
    return bool(DIGITS.fullmatch(word)) and math.isfinite(float(word))


def _check_children(element: Any) -> None:
    allowed = CHILDREN.get(element.tag, ())
    if allowed is None:
        return
    tags = [child.tag for child in _elements(element)]
    for child in _elements(element):
        tag = child.tag
        if tag not in allowed:
            reason = WHY_NOT.get(
                tag, f'is not supported in <{element.tag}>; allowed: {", ".join(allowed)}'
            )
            raise InvalidModel(f'<{tag}> (line {child.sourceline}): {reason}')
        if tag in WHY_ONE and tags.count(tag) > 1:
            names = ', '.join(
                shown(one.get('name') or '?') for one in _elements(element) if one.tag == tag
            )
            listed = f' ({names})' if tag == 'link' else ''
            raise InvalidModel(
                f'<{element.tag}> (line {element.sourceline}) has {tags.count(tag)} '
                f'<{tag}>{listed}; one is supported: {WHY_ONE[tag]}'
            )


def _one_line(message: object) -> str:
    return ' '.join(str(message).split())
