# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The tables of `docs/node.md`, from the code: topics, services and parameters of the node; and that
of `docs/viewers.md`, the views.

    python tools/node_reference.py           writes them into the pages
    python tools/node_reference.py --check   exit code 1 where a page is not what the code says

A topic of which neither a view nor the tables below say a word is an error.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / 'docs' / 'node.md'
VIEWERS = ROOT / 'docs' / 'viewers.md'
HEADING = '## Reference\n'
VIEWS_HEAD = '| topic | type | node | `simulate` |\n|---|---|---|---|\n'
BODY = 'body'
SCENE = {
    'version': 1,
    'name': 'reference',
    'dt': 0.001,
    'contact': {'mode': 'event'},
    'bodies': [
        {'name': BODY, 'shape': {'type': 'sphere', 'radius': 0.1}, 'mass': 1.0},
        {'name': 'floor', 'shape': {'type': 'plane', 'normal': [0, 0, 1]}, 'fixed': True},
    ],
}
COMMANDS = {
    'force': 'held force [N] at the centre of mass',
    'torque': 'held torque [N m]',
    'wrench': 'held force and torque [N, N m], both at once',
    'impulse': 'applied once [N s, N m s], whatever the tick',
    'set_state': 'pose and twist of the centre of mass from the next tick on',
}
OF_STATES = {
    '<body>/pose': 'pose of the centre of mass in the world frame',
    '<body>/twist': 'velocity of the centre of mass and angular velocity, world axes',
    '<body>/applied_wrench': 'what commands exerted over the last tick, stamped with its start',
    '<body>/contacts': 'where the body touches others, and the force of each contact; '
    '`publish_contacts`',
}
OTHERS = {  # behind those of the views
    '~/impacts': 'impacts at their instants since the last published states, with the next ones, '
    'at a reset or at the end; in scenes with '
    '`contact: {mode: event}`; fields: [Impacts at their instants](event_contact.md)',
    '/clock': 'simulation time; `publish_clock`',
    '/diagnostics': 'real-time factor, overruns, refused and lost commands, drift, energy '
    'balance, warnings; stamped with wall time, because a paused run still reports',
}
SERVICES = {
    '~/pause': ('std_srvs/srv/SetBool', 'stand still, or go on'),
    '~/step': ('std_srvs/srv/Trigger', 'do `step_count` ticks; of a paused run'),
    '~/reset': ('std_srvs/srv/Trigger', 'every body back to its start; time goes on'),
    '~/record': ('std_srvs/srv/SetBool', 'begin a bag, or close it'),
}


def topics() -> Iterator[tuple[str, str, str]]:
    """Give name, type and meaning of what is published, with everything switched on."""
    from rigid_body_sim import Simulation, load_scene
    from rigid_body_sim.runs.run import Run, RunSettings
    from rigid_body_sim.runs.view import ViewSettings
    from rigid_body_sim.runs.views import VIEWS

    run = Run(
        Simulation(load_scene(SCENE)),
        RunSettings(publish_contacts=True, view=ViewSettings(frozenset(VIEWS))),
    )
    meanings = {
        topic: f'{meaning}; `{view.parameter}`'
        for view in VIEWS.values()
        for topic, meaning in view.topics.items()
    }
    meanings = OF_STATES | meanings | OTHERS
    seen = {}
    for topic in run.topics:
        if '/floor/' not in topic.name:
            seen[_shown(topic.name)] = topic.type
    seen['/diagnostics'] = 'diagnostic_msgs/msg/DiagnosticArray'
    for name in [*meanings, *seen]:
        if (name in seen) != (name in meanings):
            raise SystemExit(f'{name}: published and described are not the same')
    for name, meaning in meanings.items():
        yield name, seen[name], meaning


def _shown(name: str) -> str:
    """Name a topic as users write it."""
    if name in ('/clock', '/tf'):
        return name
    name = name.removeprefix('/').replace('rigid_body_sim/', '~/')
    return f'<body>{name.removeprefix(BODY)}' if name.startswith(f'{BODY}/') else name


def reference() -> Iterator[str]:
    """Give the lines of the tables."""
    from rigid_body_sim.recording.topics import COMMAND_TYPES
    from rigid_body_sim.ros.parameters import PARAMETERS, allowed
    from rigid_body_sim.ros.standard.offered import SERVICES as STANDARD

    yield '\n### Topics it publishes\n\n| topic | type | meaning |\n|---|---|---|\n'
    for name, kind, meaning in topics():
        yield f'| `{name}` | `{kind}` | {meaning} |\n'
    yield '\n### Topics it takes\n\n| topic | type | meaning |\n|---|---|---|\n'
    for leaf, kind in COMMAND_TYPES.items():
        yield f'| `<body>/{leaf}` | `{kind}` | {COMMANDS[leaf]} |\n'
    yield '\n### Services\n\n| service | type | does |\n|---|---|---|\n'
    for name, (kind, does) in SERVICES.items():
        yield f'| `{name}` | `{kind}` | {does} |\n'
    names = ', '.join(f'`~/{service.name}`' for service in STANDARD)
    yield (
        f'\nWhere `simulation_interfaces` is installed also {names} '
        '([simulation_interfaces.md](simulation_interfaces.md)).\n'
    )
    yield '\n### Parameters\n\nLive ones may be changed while the node runs.\n\n'
    yield '| parameter | default | allowed | live | meaning |\n|---|---|---|---|---|\n'
    for entry in PARAMETERS:
        default = '[]' if entry.default == () else entry.default
        default = str(default).lower() if isinstance(default, bool) else default
        words = entry.description.replace('|', '\\|').replace('<', '\\<')
        yield (
            f'| `{entry.name}` | `{default if default != "" else repr("")}` | {allowed(entry)} | '
            f'{"yes" if entry.live else ""} | {words} |\n'
        )


def views() -> Iterator[str]:
    """Give the rows of the views."""
    from rigid_body_sim.runs.views import VIEWS

    kinds = {name: kind.replace('/msg/', '/') for name, kind, _ in topics()}
    for view in VIEWS.values():
        names = ', '.join(f'`{name}`' for name in view.topics)
        types = ', '.join(dict.fromkeys(kinds[name] for name in view.topics))
        yield f'| {names} | {types} | `{view.parameter}` | `{view.option}` |\n'


def page() -> str:
    """Give the page of the node as it should be, with its tables below its last heading."""
    text = PAGE.read_text(encoding='utf-8')
    head = text[: text.index(HEADING) + len(HEADING)]
    return head + ''.join(reference())


def page_of_views() -> str:
    """Give the page of the views as it should be, with its first table."""
    text = VIEWERS.read_text(encoding='utf-8')
    head, _, rest = text.partition(VIEWS_HEAD)
    return head + VIEWS_HEAD + ''.join(views()) + rest[rest.index('\n\n') + 1 :]


if __name__ == '__main__':
    sys.path.insert(0, str(ROOT))
    wanted = {PAGE: page(), VIEWERS: page_of_views()}
    if '--check' in sys.argv:
        sys.exit(any(path.read_text(encoding='utf-8') != text for path, text in wanted.items()))
    for path, text in wanted.items():
        path.write_text(text, encoding='utf-8')
