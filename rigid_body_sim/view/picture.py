# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
One page about a recorded run: what should come out, where the bodies went, how they turn, what
acted on them, energy, and what should have stayed the same. What is nothing has no panel.
"""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from rigid_body_sim.analysis.recorded_contacts import HOW_TO_RECORD
from rigid_body_sim.physics.model import rotation
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.physics.state.impacts import Impacts
from rigid_body_sim.view.drawn_part import note_of
from rigid_body_sim.view.energy_history import EnergyHistory, spin_of
from rigid_body_sim.view.line_styles import NAMED_BODIES, OTHERS, color_places, style
from rigid_body_sim.view.recorded_motion import RecordedMotion, Track
from rigid_body_sim.view.trajectory import draw_trajectories, has_trajectory

Array = NDArray[np.float64]

NO_CONTACTS = f'Contacts were not recorded: {HOW_TO_RECORD}'
NO_ENERGY = 'The bag holds no scene, or not every body of it: masses are unknown.'

WIDTH = 13.0  # [inch]
OVERVIEW, PANEL, ROW, LINE = (
    5.4,
    1.55,
    1.6,
    0.21,
)  # [inch] heights: first part, panels, a text line
LETTERS = 150  # of a line of text
NO_DRIFT = 1e-17  # [-] zero has no place on a logarithmic axis: this tick stands for it
PIXELS = 600  # width of a panel: more marks than that hide each other
CROWD = 30  # bodies: of more, a panel shows how they are distributed
TOTAL = {'color': '#000000', 'linestyle': (0, (1, 2)), 'linewidth': 2.0, 'zorder': 4}
LAWS = ('energy', 'momentum', 'angular momentum')
XYZ = ('x', 'y', 'z')


@dataclass(frozen=True, eq=False)
class Row:
    """
    One quantity of the bodies by its three components.

    title  : with the unit
    parts  : names of the components
    curves : of each body: time (k,) and values (k, 3); None where it has none
    marks  : drawn as marks, because they come and go
    """

    title: str
    parts: Sequence[str]
    curves: list[tuple[Array, Array] | None]
    marks: bool = False

    @property
    def says_something(self) -> bool:
        """Whether any of it is not zero."""
        return self.largest > 0.0

    @property
    def largest(self) -> float:
        """Largest magnitude of all."""
        sizes = [float(np.nanmax(np.abs(c[1]), initial=0.0)) for c in self.curves if c]
        return max(sizes, default=0.0)


def picture(
    motion: RecordedMotion,
    energy: EnergyHistory | None,
    *,
    title: str,
    caption: str = '',
    scene: Scene | None = None,
) -> Figure:
    """
    Draw the page.

    energy  : None: the bag does not say what the bodies weigh
    caption : below the title: what is expected of the scene
    scene   : for angular momenta; what it calls fixed is not drawn; None: unknown
    """
    places = color_places([track.name for track in motion.tracks], scene)
    shown = [track for track in motion.tracks if track.name in places] or list(motion.tracks)
    motion = replace(motion, tracks=tuple(shown))
    panels = _panels(motion, energy)
    rows = [row for row in _rows(motion, scene) if row.says_something]
    notes = _notes(motion, energy, caption)
    travels = has_trajectory(motion)
    overview = max(OVERVIEW if travels else 0.0, PANEL * len(panels))
    legend = 1 + (min(len(shown), NAMED_BODIES + 1) - 1) // 6
    text = LINE * (len(notes) + 1.4 * legend + 0.6)
    figure = Figure(figsize=(WIDTH, 0.5 + text + overview + ROW * len(rows)), layout='constrained')
    figure.suptitle(title, fontsize=14, fontweight='bold', parse_math=False)  # a name may hold a $
    heights = [text, *([overview] if overview else []), *[ROW] * len(rows)]
    grid = figure.add_gridspec(len(heights), 1, height_ratios=heights)
    names = [track.name for track in shown]
    if overview:
        names = _overview(figure, grid[1], motion, panels, travels=travels)
    _heading(figure.add_subplot(grid[0]), notes, names)
    for i, row in enumerate(rows, start=len(heights) - len(rows)):
        _components(figure, grid[i], row, last=row is rows[-1])
    return figure


def _panels(motion: RecordedMotion, energy: EnergyHistory | None) -> list[Callable[[Axes], None]]:
    """Give the panels of all bodies together that have something to show, as what draws them."""
    panels: list[Callable[[Axes], None]] = []
    if energy is not None:
        panels.append(lambda axes: _energy(axes, energy, motion.command_time))
        if _has_drift(energy):
            panels.append(lambda axes: _drift(axes, energy))
    if motion.loads and any(len(load.time) for load in motion.loads.values()):
        panels.append(lambda axes: _loads(axes, motion))
    impacts = motion.impacts
    if impacts is not None and len(impacts):
        panels.append(lambda axes: _impacts(axes, impacts))
    return panels


def _notes(motion: RecordedMotion, energy: EnergyHistory | None, caption: str) -> list[str]:
    """Lines below the title: what is expected, and what the bag does not tell."""
    said = [text for text in (note_of(motion), caption) if text]
    if energy is None:
        said.append(NO_ENERGY)
    if motion.loads is not None and not motion.loads:
        said.append(' '.join(NO_CONTACTS.split()))
    return [line for text in said for line in textwrap.wrap(text, LETTERS)]


def _rows(motion: RecordedMotion, scene: Scene | None) -> list[Row]:
    """Give every quantity by its components, body by body."""
    tracks = motion.tracks
    bodies = {body.name: body for body in (() if scene is None else scene.bodies)}

    def spin(track: Track) -> tuple[Array, Array] | None:
        body = bodies.get(track.name)
        if body is None or body.inertia is None or body.fixed or not len(track.twist_time):
            return None
        turns = _orientation(track)
        passed = motion.passed(track.twist_time)
        return track.twist_time, spin_of(body, passed, turns, track.angular_velocity)

    def rates(track: Track) -> tuple[Array, Array] | None:
        if not len(track.twist_time):
            return None
        return track.twist_time, rotation.rotate_back(_orientation(track), track.angular_velocity)

    def attitude(track: Track) -> tuple[Array, Array] | None:
        turns = np.ptp(track.orientation, axis=0).any()
        return (track.time, roll_pitch_yaw(track.orientation)) if turns else None

    return [
        Row('position [m]', XYZ, [_bare(t.time, t.position) for t in tracks]),
        Row('velocity [m/s]', XYZ, [_bare(t.twist_time, t.velocity) for t in tracks]),
        Row('attitude [°]', ('roll', 'pitch', 'yaw'), [attitude(t) for t in tracks], marks=True),
        Row('angular velocity [rad/s], body axes', XYZ, [rates(t) for t in tracks]),
        Row('angular momentum [kg m²/s], world axes', XYZ, [spin(t) for t in tracks]),
        Row('commanded force [N]', XYZ, [_bare(t.wrench_time, t.force) for t in tracks]),
        Row('commanded torque [N m]', XYZ, [_bare(t.wrench_time, t.torque) for t in tracks]),
    ]


def _bare(time: Array, values: Array) -> tuple[Array, Array] | None:
    return (time, values) if len(time) else None


def _orientation(track: Track) -> Array:
    """Orientation (j, 4) at the times of the twists."""
    if np.array_equal(track.time, track.twist_time):
        return track.orientation
    nearest = np.searchsorted(track.time, track.twist_time - 1e-9)
    return track.orientation[np.clip(nearest, 0, len(track.time) - 1)]


def roll_pitch_yaw(orientation: Array) -> Array:
    """Angles (k, 3) [degree] about x, y, z with R = Rz Ry Rx, of quaternions (k, 4) xyzw."""
    x, y, z, w = orientation.T
    roll = np.arctan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    pitch = np.arcsin(np.clip(2.0 * (w * y - z * x), -1.0, 1.0))
    yaw = np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    return np.degrees(np.stack((roll, pitch, yaw), axis=1))


def _overview(
    figure: Figure,
    place: SubplotSpec,
    motion: RecordedMotion,
    panels: list[Callable[[Axes], None]],
    *,
    travels: bool,
) -> list[str]:
    """Draw paths and panels side by side; returns what the legend names."""
    columns = 2 if travels and panels else 1
    grid = place.subgridspec(max(1, len(panels)), columns, width_ratios=(1.05, 1.0)[:columns])
    names = [track.name for track in motion.tracks]
    if travels:
        names = draw_trajectories(figure, grid[:, 0], motion)
    axes: list[Axes] = []
    for i, draw in enumerate(panels):
        axes.append(figure.add_subplot(grid[i, -1], sharex=axes[0] if axes else None))
        draw(axes[-1])
        axes[-1].grid(alpha=0.3)
        axes[-1].tick_params(labelbottom=draw is panels[-1])
    if axes:
        axes[-1].set_xlabel('simulation time [s]')
        figure.align_ylabels(axes)
    return names


def _heading(axes: Axes, notes: list[str], names: list[str]) -> None:
    """Write the lines, and name the first bodies; say how many more there are."""
    axes.axis('off')
    text = axes.text(0.5, 1.0, '\n'.join(notes), transform=axes.transAxes, color='#444444')
    text.set(ha='center', va='top', parse_math=False, fontsize=10)
    lines = [
        Line2D([], [], **style(index), label=name)
        for index, name in enumerate(names[:NAMED_BODIES])
    ]
    more = len(names) - NAMED_BODIES
    if more > 0:
        lines.append(Line2D([], [], **OTHERS, label=f'{more} more bodies, not named'))
    legend = axes.legend(
        handles=lines, loc='lower center', ncols=6, handlelength=3.0, frameon=False, fontsize=9
    )
    for name in legend.get_texts():
        name.set_parse_math(False)


def _components(figure: Figure, place: SubplotSpec, row: Row, *, last: bool) -> None:
    """Draw three panels side by side with one scale, unless that would hide one of them."""
    grid = place.subgridspec(1, 3)
    for i, part in enumerate(row.parts):
        axes = figure.add_subplot(grid[0, i])
        axes.set_title(f'{row.title}: {part}', fontsize=9, loc='left')
        axes.grid(alpha=0.3)
        axes.tick_params(labelsize=8)
        if len(row.curves) > CROWD:
            _distribution(axes, row, i)
        else:
            _lines(axes, row, i)
        _calm(axes, largest=row.largest)
        if last:
            axes.set_xlabel('simulation time [s]', fontsize=9)


def _lines(axes: Axes, row: Row, component: int) -> None:
    for index, curve in reversed(list(enumerate(row.curves))):
        if curve is None:
            continue
        time, values = curve
        line: dict[str, Any] = style(index) | {'linewidth': 1.3}
        if row.marks:
            values = _broken(values)
        axes.plot(time, values[:, component], **line)


def _broken(angles: Array) -> Array:
    """Leave a gap where an angle wraps."""
    broken = angles.copy()
    broken[1:][np.abs(np.diff(angles, axis=0)) > 180.0] = np.nan
    return broken


def _distribution(axes: Axes, row: Row, component: int) -> None:
    """Median, nine of ten, and all of many bodies at the instants of the one with most."""
    curves = [curve for curve in row.curves if curve]
    time = max((curve[0] for curve in curves), key=len)
    values = np.stack([np.interp(time, t, v[:, component]) for t, v in curves], axis=1)
    low, below, middle, above, high = np.quantile(values, (0.0, 0.05, 0.5, 0.95, 1.0), axis=1)
    axes.fill_between(time, low, high, color='#0072B2', alpha=0.15, linewidth=0, label='all')
    axes.fill_between(time, below, above, color='#0072B2', alpha=0.35, linewidth=0, label='90 %')
    axes.plot(time, middle, color='#0072B2', linewidth=1.4, label='median')
    if component == 0:
        axes.legend(loc='best', fontsize=7, ncols=3, framealpha=0.8)


def _energy(axes: Axes, energy: EnergyHistory, command_time: Array) -> None:
    axes.set_ylabel('energy [J]')
    total = energy.kinetic + energy.potential
    axes.plot(energy.time, energy.kinetic, **style(0), label='kinetic')
    axes.plot(energy.time, energy.potential, **style(1), label='potential')
    axes.plot(energy.time, total, **TOTAL, label='total')
    _works(axes, energy)
    if len(command_time):
        step = max(float(energy.time[-1]), 1e-9) / PIXELS
        marks = np.unique(np.round(command_time / step)) * step
        foot = {'transform': axes.get_xaxis_transform(), 'color': '#777777', 'markersize': 9}
        axes.plot(marks, np.zeros_like(marks), '|', **foot, label='commands act')
    _key(axes)
    _calm(axes)


def _works(axes: Axes, energy: EnergyHistory) -> None:
    """Draw what was brought in and taken since the begin, as far as there is any."""
    balance = energy.balance
    if balance is None:
        return
    for place, name, work in (
        (2, 'work of commands', balance.commands),
        (3, 'work of drives', balance.drives),
        (5, 'dissipated', balance.dissipation),
        (6, 'taken by contact', balance.contact),
    ):
        if np.any(work):
            axes.plot(balance.time, work, **style(place), label=name)


def _has_drift(energy: EnergyHistory) -> bool:
    """Whether any law holds, or the run kept its energy balance."""
    balance = energy.balance
    kept = np.isfinite(energy.drift).all(axis=0).any()
    return bool(kept) or (balance is not None and balance.turnover > 0.0)


def _drift(axes: Axes, energy: EnergyHistory) -> None:
    axes.set_ylabel('worst drift so far [–]')
    kept = [i for i in range(len(LAWS)) if np.isfinite(energy.drift[:, i]).all()]
    balance = energy.balance
    axes.set_yscale('log')
    names = ('rise of energy', *LAWS[1:]) if energy.may_only_fall else LAWS
    for i in kept:
        values = np.maximum(np.abs(energy.drift[:, i]), NO_DRIFT)
        axes.plot(energy.time, values, **style(i), label=names[i])
    if balance is not None and balance.turnover > 0.0:
        defect = np.maximum(np.abs(balance.defect) / balance.turnover, NO_DRIFT)
        axes.plot(balance.time, defect, **style(3), label='defect of the energy balance')
        axes.set_ylabel('worst drift so far, defect [–]' if kept else 'defect [–]')
    rounding = {'color': '#555555', 'linewidth': 0.8, 'linestyle': (0, (1, 2))}
    axes.axhline(np.finfo(float).eps, **rounding, label='one rounding')
    drawn = [line.get_ydata() for line in axes.get_lines()]
    largest = max((float(np.nanmax(y)) for y in map(np.asarray, drawn) if y.size), default=0.0)
    decades = np.arange(np.log10(NO_DRIFT), max(-12.0, np.log10(max(NO_DRIFT, largest)) + 1.0))
    decades = decades[:: 1 + len(decades) // 7]
    axes.set_ylim(0.3 * NO_DRIFT, 10.0 ** (decades[-1] + 2.0))
    ticks = [f'$10^{{{decade:.0f}}}$' for decade in decades]
    axes.set_yticks(10.0**decades, ['0', *ticks[1:]])
    axes.minorticks_off()
    _key(axes)


def _loads(axes: Axes, motion: RecordedMotion) -> None:
    """Draw the sum over the contacts of each body: marks, because they come and go."""
    axes.set_ylabel('contact force [N]')
    assert motion.loads is not None
    for index, track in reversed(list(enumerate(motion.tracks))):
        load = motion.loads.get(track.name)
        if load is not None and len(load.time):
            line = style(index) | {'linestyle': 'none', 'marker': '.', 'markersize': 2.5}
            axes.plot(load.time, load.force, **line)
    axes.set_ylim(bottom=0.0)


def _impacts(axes: Axes, found: Impacts) -> None:
    """Draw the impulse of each impact at its instant."""
    axes.set_ylabel('impacts [N s]')
    sizes = np.linalg.norm(found.impulse, axis=1)
    axes.vlines(found.time, 0.0, sizes, color='#e03131', linewidth=0.8)
    axes.plot(found.time, sizes, color='#e03131', linestyle='none', marker='o', markersize=2.5)
    axes.set_ylim(bottom=0.0)


def _key(axes: Axes) -> None:
    axes.legend(loc='best', fontsize=8, ncols=2, handlelength=4, framealpha=0.85)


def _calm(axes: Axes, *, largest: float = 0.0) -> None:
    """Do not blow up round-off: an axis spans at least a millionth of its values."""
    low, high = axes.get_ylim()
    middle, least = 0.5 * (low + high), 1e-6 * max(abs(low), abs(high), largest, 1e-9)
    if high - low < least:
        axes.set_ylim(middle - 0.5 * least, middle + 0.5 * least)
    axes.ticklabel_format(axis='y', useOffset=False)
