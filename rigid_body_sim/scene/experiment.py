# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Read a whole scene: one YAML document is one experiment.

SI units, z up, quaternions xyzw. Every key is read by somebody or refused; every refusal is a
UserError of one line that names the place in the document.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model.scene import Body, Origin, Scene
from rigid_body_sim.physics.model.tick_length import tick_nanoseconds
from rigid_body_sim.physics.validation import LONGEST_TITLE, NAME, check_scene
from rigid_body_sim.scene import document, grammar, numerals, regular_file
from rigid_body_sim.scene.bodies import read_bodies
from rigid_body_sim.scene.contact import read_contact
from rigid_body_sim.scene.files import Files
from rigid_body_sim.scene.forces import read_force
from rigid_body_sim.scene.refusal import refusal
from rigid_body_sim.scene.shipped_scenes import find_scene
from rigid_body_sim.scene.urdf import read_link
from rigid_body_sim.scene.values import Value, shown

VERSION = 1
MOST_BODIES = 100_000  # [-] more are a slip of the pen, and would fill the memory
URDF_SUFFIX = '.urdf'
OF_URDF = {'dt': 0.001, 'gravity': [0.0, 0.0, -9.81]}  # [s], [m/s^2] around a lone URDF file


def load_scene(
    source: str | Path | Mapping[str, Any] | bytes,
    *,
    files: Mapping[str, bytes] | None = None,
    title: str = 'scene',
) -> Scene:
    """
    Read and check a scene.

    source : path of a YAML file, the name of a scene that comes with the package ('satellite'), a
             mapping with the same keys, or the bytes of a YAML text; also path of a URDF file:
             then the scene is that body alone, under `OF_URDF`
    files  : the bytes of the files that the scene names; without it they are read from the folder
             of the scene file (for a mapping or bytes: the current folder), with it the disk is
             not touched for them
    title  : what to call a mapping or bytes that do not name themselves

    Raises UserError, one line with place and cure, for what is no scene.
    """
    if isinstance(source, str):
        source = _path_of(source)
    if isinstance(source, str | Path) and Path(source).suffix.lower() == URDF_SUFFIX:
        return _scene_of_urdf(Path(source), files)
    text, name, folder = _text(source, title)
    origin = Origin(name, has_lines=not isinstance(source, Mapping))
    return _scene(origin, text=text, files=Files(folder=folder, given=files))


def _path_of(text: str) -> Path:
    """Return the path that a text is, or the path of the shipped scene that it names."""
    if '\n' in text:
        raise UserError(
            f'scene: got a text of {len(text.splitlines())} lines; the path of a scene file or '
            'the name of a shipped scene is needed (YAML itself is given as bytes: '
            'load_scene(text.encode()))'
        )
    if not text:
        raise UserError(
            "scene: got ''; the path of a scene file or the name of a shipped scene is needed"
        )
    return find_scene(text)


def _scene_of_urdf(path: Path, given: Mapping[str, bytes] | None) -> Scene:
    """
    Write the scene of one URDF file, and read it: what a bag keeps of it is an ordinary scene.
    """
    files = Files(folder=path.parent, given=given)
    try:
        link = read_link(files, path.name)
    except InvalidModel as error:
        told = os.path.join(path.parent, str(error))  # noqa: PTH118  (a message, no path)
        raise UserError(told) from error
    if not NAME.fullmatch(link.name):
        raise UserError(
            f'{path}: <link name={shown(link.name)}> is no name for topics; name the body in a '
            'scene: '
            f'bodies: [{{name: box, urdf: {path.name}}}]'
        )
    body = {'name': link.name, 'urdf': path.name}
    text = document.write({'version': VERSION, 'name': link.robot, **OF_URDF, 'bodies': [body]})
    return _scene(Origin(str(path)), text=text, files=files)


def _text(source: str | Path | Mapping[str, Any] | bytes, title: str) -> tuple[bytes, str, Path]:
    """Return the exact bytes, what to call them, and the folder for relative names."""
    if isinstance(source, Mapping):
        return document.write(dict(source)), title, Path()
    if isinstance(source, bytes):
        return source, title, Path()
    if not isinstance(source, str | Path):
        raise UserError(
            f'scene: got {shown(source)}; the path of a scene file, the name of a shipped scene, '
            'a mapping or bytes of YAML are needed'
        )
    path = Path(source)
    try:
        return regular_file.read(path), str(path), path.parent
    except (OSError, ValueError) as error:
        raise UserError(
            f'{path}: cannot be read: {regular_file.reason(error)}; give the path of a scene file '
            '(YAML)'
        ) from error


class ReadBodies:
    """
    The bodies of contents that were read before: who reads many scenes that differ in few bodies
    reads each body once. Contents are told apart by being the same object.
    """

    def __init__(self) -> None:
        self._known: dict[int, tuple[Any, tuple[Body, ...]]] = {}

    def of(self, item: Value, files: Files) -> tuple[Body, ...]:
        """Read the bodies of one entry, or give those that were read."""
        known = self._known.get(id(item.content))
        if known is not None:
            return known[1]
        return tuple(read_bodies(item, files))

    def remember(self, contents: Sequence[Any], name: str, files: Files) -> None:
        """Read entries that will come again; what is refused will be refused then."""
        bodies = Value({'bodies': list(contents)}, document.Document(name, None))
        for place, content in enumerate(contents):
            item = bodies.below(('bodies', place))
            with suppress(UserError):
                self._known[id(content)] = (content, tuple(read_bodies(item, files)))


def scene_of_content(
    content: Mapping[str, Any], *, name: str, files: Files, bodies: ReadBodies | None = None
) -> Scene:
    """
    Read the content of a scene that was parsed before, or made of one: it has no text of its own.

    content : plain values, as `document.read` gives them
    name    : what messages call it
    bodies  : that were read before

    Raises UserError as `load_scene` does.
    """
    parsed = document.Document(name, content)
    return _scene_of(parsed, Origin(name), text=b'', files=files, known=bodies or ReadBodies())


def _scene(origin: Origin, *, text: bytes, files: Files) -> Scene:
    parsed = document.read(text, name=origin.name, with_lines=origin.has_lines)
    return _scene_of(parsed, origin, text=text, files=files, known=ReadBodies())


def _scene_of(
    parsed: document.Document, origin: Origin, *, text: bytes, files: Files, known: ReadBodies
) -> Scene:
    value = Value(parsed.content, parsed)
    value.need_mapping('a mapping with dt and bodies')
    value.need_known(grammar.SCENE.keys, ignored=grammar.SCENE.ignored)
    _check_version(value.find('version'))
    dt_ns = _tick(value.at('dt', what='the tick length [s]'))
    bodies = _bodies(value, files, known)
    names = [body.name for body in bodies]
    forces = value.find('forces')
    settings = {
        **_integrator(value),
        'gravity': None
        if (gravity := value.find('gravity')) is None
        else gravity.vector(unit='m/s^2'),
        'forces': None
        if forces is None
        else tuple(read_force(item, names) for item in forces.items()),
    }
    scene = Scene(
        name=_name(value),
        dt_ns=dt_ns,
        bodies=bodies,
        contact=read_contact(value.find('contact'), _copies(value, names)),
        source=text,
        origin=origin,
        files=files.used,
        **{key: setting for key, setting in settings.items() if setting is not None},
    )
    try:
        check_scene(scene)
    except InvalidModel as error:
        raise refusal(scene, error, parsed) from error
    return scene


def _check_version(value: Value | None) -> None:
    if value is None:
        return
    given = value.content
    number = numerals.decimal(given) if isinstance(given, str) else given  # as of all numbers
    if number != VERSION or isinstance(given, bool):
        raise value.error(
            f'got {shown(value.content)}; this program reads scenes of version {VERSION}'
        )


def _name(value: Value) -> str:
    given = value.find('name')
    if given is not None:
        return given.text('a name')
    stem = Path(value.document.name).stem[:LONGEST_TITLE]
    return ''.join(letter if letter.isprintable() else '?' for letter in stem)


def _tick(value: Value) -> int:
    with value.blamed():
        return tick_nanoseconds(value.number(unit='s'))


def _integrator(scene: Value) -> dict[str, Any]:
    """
    Read the integrator and its options.

        integrator: rk45                                   its name alone
        integrator: {name: rk45, rtol: 1e-9, atol: 1e-12}  with options
        orientation: matrix                                short for the option of that name of a
        Runge–Kutta method orientation: {representation: matrix, reorthonormalise: false}
    """
    value, orientation = scene.find('integrator'), scene.find('orientation')
    if value is None and orientation is None:
        return {}
    # compiled kernels come with them: only when an integrator is named
    from rigid_body_sim.physics.integration import choose
    from rigid_body_sim.physics.integration.integrators import INTEGRATORS

    name, options = Scene.integrator, {}
    names = (*INTEGRATORS, choose.NAME)
    if value is not None and isinstance(value.content, dict):
        named = value.at('name', what='the name of an integrator')
        name = named.choice(names, what='integrator')
        known = choose.OPTIONS if name == choose.NAME else INTEGRATORS[name].options
        value.need_known(('name', *known))
        options = {key: _option(given, known[key]) for key in known if (given := value.find(key))}
    elif value is not None:
        name = value.choice(names, what='integrator')
    if orientation is not None:
        options |= _orientation(orientation, name, INTEGRATORS)
    return {'integrator': name, 'integrator_options': options}


def _orientation(value: Value, name: str, integrators: Mapping[str, Any]) -> dict[str, Any]:
    known = integrators[name].options if name in integrators else {}
    if 'orientation' not in known:
        able = ', '.join(
            other for other in integrators if 'orientation' in integrators[other].options
        )
        raise value.error(
            f'integrator {name!r} keeps orientation its own way; a choice is given by: {able}'
        )
    if not isinstance(value.content, dict):
        return {'orientation': _option(value, known['orientation'])}
    value.need_known(grammar.ORIENTATION.keys)
    representation = value.at('representation', what='quaternion or matrix')
    read = {'orientation': _option(representation, known['orientation'])}
    if (given := value.find('reorthonormalise')) is not None:
        read['reorthonormalise'] = _option(given, known['reorthonormalise'])
    return read


def _option(value: Value, option: Any) -> Any:
    """Read one option; decimals may be text, as YAML reads 1e-9."""
    if option.choices:
        return value.choice(option.choices, what=str(value.path[-1]))
    if isinstance(option.default, bool):
        return value.truth()
    if isinstance(option.default, int):
        return value.whole(minimum=option.minimum, maximum=option.maximum)
    return value.number(unit='-', minimum=option.minimum, maximum=option.maximum)


def _bodies(value: Value, files: Files, known: ReadBodies) -> tuple[Body, ...]:
    items = value.at('bodies', what='a list of bodies').items('a list of bodies')
    if not items:
        raise value.error('bodies is empty; a scene needs at least one body')
    bodies: dict[str, Body] = {}
    for item in items:
        for body in known.of(item, files):
            if body.name in bodies:
                raise item.at('name', what='a name').error(
                    f'the name {body.name!r} is taken by an earlier body; names must differ'
                )
            bodies[body.name] = body
        if len(bodies) > MOST_BODIES:
            raise value.error(f'more than {MOST_BODIES} bodies; make fewer copies')
    return tuple(bodies.values())


def _copies(value: Value, names: Sequence[str]) -> dict[str, tuple[str, ...]]:
    """Give the names of the copies of each body that is repeated."""
    written = {str(body['name']) for body in value.content['bodies'] if body.get('repeat')}
    copies: dict[str, list[str]] = {}
    for name in names if written else ():
        stem = name.rpartition('_')[0]
        if stem in written:
            copies.setdefault(stem, []).append(name)
    return {stem: tuple(found) for stem, found in copies.items()}
