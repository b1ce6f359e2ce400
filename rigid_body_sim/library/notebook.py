# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What a notebook shows: of a run the page of `view`, which plays it beside its plots; of a
simulation a table of where its bodies are. Scenes tell of themselves (`shown_scene`).

The page is whole in itself, in a frame of its own: its scripts and colours touch nothing of the
notebook, and it asks no network for anything.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import suppress
from html import escape

import numpy as np

from rigid_body_sim.analysis.scene_begin import scene_began
from rigid_body_sim.errors import RunError, UserError
from rigid_body_sim.library import account
from rigid_body_sim.library.run_arrays import RunArrays
from rigid_body_sim.physics.simulation import Simulation
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.view.drawn_part import drawn_part
from rigid_body_sim.view.energy_history import energy_history
from rigid_body_sim.view.playback_page import playback_page
from rigid_body_sim.view.recorded_motion import RecordedMotion, Track

HEIGHT = 640  # [px] of the page of a run
MOST_SAMPLES, MOST_POINTS = 2000, 400_000  # of a body, of all: more change no pixel
FEWEST_SAMPLES = 200
MOST_ROWS = 50  # of a table


def page_of_run(run: RunArrays) -> str:
    """Write the page of a run: HTML that plays it in a browser, without network."""
    motion, ending = drawn_part(_motion(run), name=str(run.path or 'the run')), None
    if account.is_affordable(run):
        with suppress(RunError, UserError):  # what else a page shows is not less true
            ending = account.ending_of(run)
    about = [f'integrator {run.integrator}' * bool(run.integrator)]
    about += [f'dt = {run.dt:g} s' * bool(run.integrator), run.problem]
    return playback_page(
        motion,
        run.scene,
        title='run' if run.scene is None else run.scene.name,
        about=', '.join(filter(None, about)),
        energy=None if run.scene is None else energy_history(run.scene, motion, ending=ending),
        bag=None if run.path is None else Bag(run.path),
    )


def html_of_run(run: RunArrays) -> str:
    """Put the page of a run into a frame, with its text above."""
    lines = escape(account.summary_of(run) if len(run.time) else repr(run))
    if not len(run.time):
        return f'<pre>{lines}</pre>'
    return (
        f'<pre style="margin:0 0 4px">{lines}</pre>'
        f'<iframe srcdoc="{escape(page_of_run(run))}" title="run" allowfullscreen '
        f'style="width:100%;height:{HEIGHT}px;border:0" loading="lazy"></iframe>'
    )


def _motion(run: RunArrays) -> RecordedMotion:
    """Thin a run to what a page can show."""
    most = max(FEWEST_SAMPLES, min(MOST_SAMPLES, MOST_POINTS // max(1, len(run.names))))
    every = -(-len(run.time) // most)
    rows = np.unique(np.append(np.arange(0, len(run.time), every), len(run.time) - 1))
    time = run.time[rows]
    acts = np.zeros(len(run.time), dtype=bool)
    tracks = []
    for name in run:
        body = run[name]
        force, torque = np.nan_to_num(body.force), np.nan_to_num(body.torque)
        pushed = force.any(axis=1) | torque.any(axis=1)
        acts |= pushed
        shown = rows[pushed[rows]]
        has_twist = np.isfinite(body.velocity[rows]).all(axis=1)
        twist = rows[has_twist]
        tracks.append(
            Track(
                name,
                time,
                body.position[rows],
                body.orientation[rows],
                run.time[twist],
                body.velocity[twist],
                body.angular_velocity[twist],
                run.time[shown],
                force[shown],
                torque[shown],
            )
        )
    meets = run.scene is not None and run.scene.contact.get('mode', 'none') != 'none'
    loads = {} if meets else None
    return RecordedMotion(
        tuple(tracks), run.time[acts], loads, impacts=run.impacts, began=(_began(run),)
    )


def _began(run: RunArrays) -> float:
    """Tell when the scene of a run began [s]."""
    if run._origin is not None:
        return run._origin.start['start_ns'] / 1e9
    if run.path is None or run.scene is None:
        return 0.0
    return scene_began(Bag(run.path), run.scene) / 1e9


def html_of_simulation(simulation: Simulation) -> str:
    """Tell where a simulation stands: a row for each body."""
    state = simulation.state
    head = ('body', 'position [m]', 'orientation xyzw', 'velocity [m/s]',
            'angular velocity [rad/s]')  # fmt: skip
    rows = [
        (
            body.name,
            *(
                _numbers(array[i])
                for array in (
                    state.position,
                    state.orientation,
                    state.velocity,
                    state.angular_velocity,
                )
            ),
        )
        for i, body in enumerate(simulation.scene.bodies[:MOST_ROWS])
    ]
    more = len(simulation.scene.bodies) - len(rows)
    last = f'<p>and {more} more bodies</p>' if more else ''
    return f'<p>{escape(repr(simulation))}</p>{_table(head, rows)}{last}'


def _numbers(values: Iterable[float]) -> str:
    return ', '.join(f'{value:.6g}' for value in values)


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    if not rows:
        return ''
    heads = ''.join(f'<th>{escape(cell)}</th>' for cell in head)
    lines = ''.join(
        '<tr>' + ''.join(f'<td>{escape(cell)}</td>' for cell in row) + '</tr>' for row in rows
    )
    return f'<table><thead><tr>{heads}</tr></thead><tbody>{lines}</tbody></table>'
