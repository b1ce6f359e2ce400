# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A simulation in a file, to go on from bit for bit.

    MAGIC | sha256 of the rest, hexadecimal | head, one line of JSON | parts, one after the other

The head says what the parts are: the text of the scene, the files it names, and the state with all
that integrator and contacts remember (`Simulation.state_bytes`). What `auto` remembers is a part
of its own: a pickle in which nothing but the records of OF_AUTO may occur, so that a file from
somebody else can start no code.
"""

from __future__ import annotations

import hashlib
import io
import json
import os
import pickle
from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

from rigid_body_sim import __version__
from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.physics.simulation import Simulation
from rigid_body_sim.recording.new_output import check_folder, replacing
from rigid_body_sim.recording.paths import path_of
from rigid_body_sim.runs.manifest_values import ManifestValues
from rigid_body_sim.runs.recorder import TICK_SEMANTICS, held_as_json
from rigid_body_sim.scene import load_scene
from rigid_body_sim.scene.writing import with_text

MAGIC = b'rigid_body_sim checkpoint\n'
# 2: the impulse cache keeps what full detections found (`collision.recycling`); 3: and where lines
# of contact bore (`solver.surface_loads`)
VERSION = 3
SCENE, STATE, AUTO = 'scene', 'state', 'auto'  # parts; files: 'file:NAME'
FILE = 'file:'
PLAIN = ('integrator', 'integrator_options', 'dt', 'tick', 'start_ns')  # of the head
_PHYSICS = 'rigid_body_sim.physics'
OF_AUTO = {
    (f'{_PHYSICS}.errors', 'SimulationDiverged'),
    (f'{_PHYSICS}.forces.held_wrenches', 'Slot'),
    (f'{_PHYSICS}.integration.candidates', 'Setting'),
    (f'{_PHYSICS}.integration.choose', 'Choice'),
    (f'{_PHYSICS}.integration.choose', 'Plan'),
    (f'{_PHYSICS}.integration.lookout', 'Look'),
    (f'{_PHYSICS}.integration.lookout', 'Lookout'),
    (f'{_PHYSICS}.integration.lookout', 'RecordedChoices'),
    (f'{_PHYSICS}.integration.lookout', 'Watch'),
    (f'{_PHYSICS}.simulation', 'Simulation'),
}
_MISFITS = (InvalidModel, ValueError, LookupError, TypeError, AttributeError, ArithmeticError,
            EOFError, pickle.UnpicklingError, UserError)  # fmt: skip


def write(simulation: Simulation, path: str | os.PathLike[str]) -> None:
    """Write a checkpoint; see `library.simulation.Simulation.save`."""
    place = path_of(path, said='save')
    check_folder(place)
    kept = simulation.__getstate__()
    scene = with_text(kept['scene'])
    parts = {SCENE: scene.source, STATE: kept['state']}
    parts |= {FILE + name: content for name, content in scene.files.items()}
    if kept['choices'] or kept['watch'] is not None:
        parts[AUTO] = _packed_auto(kept)
    head = {
        'version': VERSION,
        'package_version': __version__,
        'tick_semantics': TICK_SEMANTICS,
        'title': scene.name,
        'slots': held_as_json(kept['slots']),
        'parts': [[name, len(content)] for name, content in parts.items()],
        **{key: kept[key] for key in PLAIN},
    }
    rest = b'\n'.join([json.dumps(head).encode(), b''.join(parts.values())])
    whole = MAGIC + hashlib.sha256(rest).hexdigest().encode() + b'\n' + rest
    with replacing(place) as new:
        new.write_bytes(whole)


def read(path: str | os.PathLike[str]) -> Mapping[str, Any]:
    """Read a checkpoint as what `Simulation.__setstate__` takes; see `write`."""
    place = path_of(path, said='load')
    try:
        whole = place.read_bytes()
    except (OSError, ValueError) as error:
        reason = getattr(error, 'strerror', None) or error
        raise UserError(f'{place}: cannot be read: {reason}') from error
    magic, found, rest = (
        whole[: len(MAGIC)],
        whole[len(MAGIC) : len(MAGIC) + 64],
        whole[len(MAGIC) + 65 :],
    )
    if magic != MAGIC:
        raise UserError(
            f'{place}: no checkpoint of a simulation; give a file that Simulation.save wrote (a '
            'bag is opened by open_bag)'
        )
    if hashlib.sha256(rest).hexdigest().encode() != found:
        raise UserError(
            f'{place}: damaged: its bytes are not those that were saved; take another checkpoint'
        )
    try:
        return _read(place, rest)
    except _MISFITS as error:
        problem = ' '.join(str(error).split())[:200] or type(error).__name__
        raise UserError(f'{place}: what it holds does not fit together: {problem}') from error


def _read(path: Path, rest: bytes) -> dict[str, Any]:
    line, _, body = rest.partition(b'\n')
    head = json.loads(line)
    said = (head['version'], head['tick_semantics'])
    if said != (VERSION, TICK_SEMANTICS):
        raise UserError(
            f'of version and tick semantics {said}, this package reads '
            f'{(VERSION, TICK_SEMANTICS)}; load it with rigid_body_sim {head["package_version"]}'
        )
    parts: dict[str, bytes] = {}
    for name, size in head['parts']:
        parts[name], body = body[:size], body[size:]
    files = {
        name.removeprefix(FILE): part for name, part in parts.items() if name.startswith(FILE)
    }
    scene = load_scene(parts[SCENE], files=files, title=head['title'])
    slots = ManifestValues(path, 'head', {'slots': json.dumps(head['slots'])})
    kept = {
        'scene': scene,
        'choices': (),
        'watch': None,
        'state': parts[STATE],
        'slots': slots.held('slots', len(scene.bodies)),
        **{key: head[key] for key in PLAIN},
    }
    return kept | (_unpacked_auto(parts[AUTO], scene) if AUTO in parts else {})


class _Packer(pickle.Pickler):
    """Writes the scene as a name."""

    def persistent_id(self, obj: Any) -> str | None:
        return SCENE if isinstance(obj, Scene) else None


class _Unpacker(pickle.Unpickler):
    """Reads the records of OF_AUTO and nothing else."""

    def __init__(self, file: io.BytesIO, scene: Scene) -> None:
        super().__init__(file)
        self._scene = scene

    def persistent_load(self, pid: Any) -> Scene:
        if pid != SCENE:
            raise pickle.UnpicklingError(f'unknown name {pid!r}')
        return self._scene

    def find_class(self, module_name: str, global_name: str) -> Any:
        if (module_name, global_name) not in OF_AUTO:
            raise pickle.UnpicklingError(f'{module_name}.{global_name} does not belong here')
        return getattr(import_module(module_name), global_name)


def _packed_auto(kept: Mapping[str, Any]) -> bytes:
    file = io.BytesIO()
    _Packer(file).dump({'choices': kept['choices'], 'watch': kept['watch']})
    return file.getvalue()


def _unpacked_auto(part: bytes, scene: Scene) -> dict[str, Any]:
    return _Unpacker(io.BytesIO(part), scene).load()
