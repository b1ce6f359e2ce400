# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What `integrator: auto` chose in a run: as messages of a bag, and in words.

Each change of method is one message on CHOICES, with the tick from which it holds as sequence
number: `header.frame_id` is the method with its options as JSON, `vector` the error per second
[m, rad] seen at the change, the tolerance, and the substeps of a tick. A replay takes the changes
at their ticks and chooses nothing itself. What held at the start stands in the manifest.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator
from typing import Any

from rigid_body_sim.errors import RunError
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.integration.choose import Choice, integrator_of
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.physics.simulation import Simulation
from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.recorded_message import RecordedMessage
from rigid_body_sim.recording.topics import Topic
from rigid_body_sim.runs.run import Run

LEAF = 'integrator'
MOST_TOLD = 5  # changes in a summary for people


def topic_of(namespace: str) -> Topic:
    """Topic of the changes of one run."""
    prefix = namespace.strip('/')
    return Topic(f'/{prefix}/{LEAF}' if prefix else f'/{LEAF}', cdr.Vector3Stamped.TYPE)


def topics_of(run: Run) -> list[Topic]:
    """Give the topic that a bag of a run needs for changes; none where there cannot be any."""
    return [] if run.simulation.watch is None else [topic_of(run.settings.namespace)]


def messages(run: Run, first: int) -> Iterator[RecordedMessage]:
    """Yield the changes of a run from its choice number `first` on, as a bag holds them."""
    topic, dt_ns = topic_of(run.settings.namespace).name, run.simulation.dt_ns
    for choice in run.simulation.choices[first:]:
        time_ns = choice.tick * dt_ns
        yield RecordedMessage(topic, choice.tick, time_ns, encode(choice, dt_ns), time_ns)


def encode(choice: Choice, dt_ns: int) -> bytes:
    """Give the message of one change."""
    sec, nanosec = divmod(choice.tick * dt_ns, 1_000_000_000)
    named = json.dumps({'name': choice.name, **choice.options})
    vector = (choice.error, choice.allowed, float(choice.substeps))
    return cdr.encode(cdr.Vector3Stamped(sec, nanosec, named, vector))


def decode(message: RecordedMessage, scene: Scene) -> Choice:
    """Read the message of one change; RunError where it is none for this scene."""
    try:
        said = cdr.decode(cdr.Vector3Stamped.TYPE, message.data)
        assert isinstance(said, cdr.Vector3Stamped)
        options: dict[str, Any] = json.loads(said.frame_id)
        name = options.pop('name')
        integrator = integrator_of(name, options)
        refusal = integrator.refuses(scene)
    except (cdr.CdrError, ValueError, TypeError, KeyError, AttributeError, InvalidModel) as error:
        refusal, name, options = str(error), '', {}
        said, integrator = None, None
    if refusal is not None or said is None or integrator is None:
        raise RunError(
            f'{message.topic}, tick {message.sequence}: no change of integrator that this scene '
            f'could have had ({refusal}); the bag is damaged, or of another version'
        )
    return Choice(
        name,
        integrator.substeps,
        said.vector[0],
        'recorded',
        options=options,
        allowed=said.vector[1],
        tick=message.sequence,
    )


def decoded(messages: Iterable[RecordedMessage], scene: Scene) -> list[Choice]:
    """Read all changes of a bag."""
    return [decode(message, scene) for message in messages]


def facts(simulation: Simulation) -> dict[str, Any]:
    """
    Give what `auto` chose and saw as plain values, for JSON; empty where the integrator was named.
    """
    if not simulation.choices:
        return {}
    first = simulation.choices[0]
    found: dict[str, Any] = {
        'integrator_choice': first.reason,
        'integrator_choices': [
            {
                'tick': each.tick,
                'integrator': each.name,
                'options': dict(each.options),
                'error_per_second': _finite(each.error),
                'reason': each.reason,
            }
            for each in simulation.choices
        ],
    }
    watch = simulation.watch
    if watch is not None:
        found['integrator_looks'] = {
            'looks': watch.looks,
            'beyond_tolerance': watch.missed,
            'largest_error_per_second': _finite(watch.worst.error) if watch.worst else None,
            'largest_at_tick': watch.worst.tick if watch.worst else None,
            'allowed_per_second': _finite(first.allowed),
        }
    return found


def summary(simulation: Simulation) -> list[str]:
    """Say in lines what `auto` chose and saw."""
    if not simulation.choices:
        return []
    lines = [each.reason for each in simulation.choices[: 1 + MOST_TOLD]]
    left = len(simulation.choices) - len(lines)
    if left:
        lines.append(f'{left} more changes; the bag holds them all')
    looks = looks_text(simulation)
    return [*lines, looks] if looks else lines


def method_text(simulation: Simulation) -> str:
    """Name the integrator that is at work, with its options."""
    settings = simulation.integrator.settings
    options = ', '.join(f'{name} {value}' for name, value in settings.items())
    return f'{simulation.integrator.name} ({options})' if options else simulation.integrator.name


def looks_text(simulation: Simulation) -> str:
    """Say what the looks found; nothing where there was none."""
    watch = simulation.watch
    if watch is None or watch.worst is None:
        return ''
    said = (
        f'{watch.looks} look{"s" if watch.looks > 1 else ""}, the worst gained '
        f'{watch.worst.error:.1e} (m, rad) per second up to '
        f'{watch.worst.tick * simulation.dt:g} s where {simulation.choices[0].allowed:.1e} is '
        'allowed'
    )
    return f'{said}; {watch.missed} beyond it' if watch.missed else said


def _finite(value: float) -> float | None:
    """JSON knows neither infinity nor NaN."""
    return value if math.isfinite(value) else None
