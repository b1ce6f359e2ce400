# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A scene in a line, and as a table of its bodies for a notebook."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape
from typing import Any

MOST_NAMES, MOST_ROWS = 6, 50  # bodies in a line, in a table
HEAD = ('body', 'shape', 'mass [kg]', 'inertia [kg m²]', 'position [m]', 'velocity [m/s]')


def line_of(scene: Any) -> str:
    """Tell of a scene in a line."""
    names = [body.name for body in scene.bodies]
    more = ', …' if len(names) > MOST_NAMES else ''
    count = f'{len(names)} {"body" if len(names) == 1 else "bodies"}'
    return (
        f'<Scene {scene.name!r}: {count} ({", ".join(names[:MOST_NAMES])}{more}), '
        f'{_surroundings(scene)}>'
    )


def html_of(scene: Any) -> str:
    """Tell of a scene in a paragraph and a table of its bodies."""
    heads = ''.join(f'<th>{cell}</th>' for cell in HEAD)
    rows = ''.join(
        '<tr>' + ''.join(f'<td>{escape(cell)}</td>' for cell in _row(body)) + '</tr>'
        for body in scene.bodies[:MOST_ROWS]
    )
    more = len(scene.bodies) - MOST_ROWS
    last = f'<p>and {more} more bodies</p>' if more > 0 else ''
    return (
        f'<p><b>{escape(scene.name)}</b>: {escape(_surroundings(scene))}</p>'
        f'<table><thead><tr>{heads}</tr></thead><tbody>{rows}</tbody></table>{last}'
    )


def _surroundings(scene: Any) -> str:
    forces = ', '.join(sorted({str(force.TYPE) for force in scene.forces})) or 'none'
    return (
        f'forces: {forces}, gravity ({_numbers(scene.gravity)}) m/s^2, contact '
        f'{scene.contact.get("mode", "none")}, {scene.integrator}, dt {scene.dt_ns * 1e-9:g} s'
    )


def _row(body: Any) -> tuple[str, ...]:
    shape = 'point' if body.is_point else type(body.shape).__name__ if body.shape else ''
    held = ' (fixed)' if body.fixed else ''
    inertia = '' if body.inertia is None else _numbers(body.inertia.diagonal().tolist())
    return (
        body.name,
        shape + held,
        '' if body.fixed and body.mass == 0.0 else f'{body.mass:g}',
        inertia,
        _numbers(body.initial.position),
        _numbers(body.initial.velocity),
    )


def _numbers(values: Iterable[float]) -> str:
    return ', '.join(f'{value:.6g}' for value in values)
