# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
One page about a recorded run: trajectories, speeds, energy, and what should have stayed the same.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from rigid_body_sim.analysis.recorded_contacts import HOW_TO_RECORD
from rigid_body_sim.view.energy_history import EnergyHistory
from rigid_body_sim.view.line_styles import NAMED_BODIES, OTHERS, style
from rigid_body_sim.view.recorded_motion import RecordedMotion, Track
from rigid_body_sim.view.trajectory import draw_trajectories

Array = NDArray[np.float64]

NO_CONTACTS = f'contacts were not recorded:\n{HOW_TO_RECORD}'

SIZE = (13.0, 9.5)  # [inch]
NO_DRIFT = 1e-17  # [-] zero has no place on a logarithmic axis: this tick stands for it
PIXELS = 600  # width of a panel: more marks than that hide each other
TOTAL = {'color': '#000000', 'linestyle': (0, (1, 2)), 'linewidth': 2.0, 'zorder': 4}
LAWS = ('energy', 'momentum', 'angular momentum')
NO_ENERGY = 'The bag holds no scene,\nor not every body of it:\nmasses are unknown.'


def picture(motion: RecordedMotion, energy: EnergyHistory | None, *, title: str) -> Figure:
    """Draw the page; `energy` None: the bag does not say what the bodies weigh."""
    rows = 4 if motion.loads is None else 5
    figure = Figure(figsize=(SIZE[0], SIZE[1] * rows / 4), layout='constrained')
    figure.suptitle(title, fontsize=13, parse_math=False)  # a name may hold a $
    grid = figure.add_gridspec(rows, 2, width_ratios=(1.05, 1.0))
    names = draw_trajectories(figure, grid[:-1, 0], motion)
    _legend(figure.add_subplot(grid[-1, 0]), names)
    top = figure.add_subplot(grid[0, 1])
    panels = [top, *(figure.add_subplot(grid[row, 1], sharex=top) for row in range(1, rows))]
    _speeds(panels[0], motion, lambda track: track.velocity, 'speed [m/s]', 'no body travels')
    _speeds(
        panels[1],
        motion,
        lambda track: track.angular_velocity,
        'angular speed [rad/s]',
        'no body turns',
    )
    if energy is None:
        for axes in panels[2:]:
            _say(axes, NO_ENERGY)
        panels[2].set_ylabel('energy [J]')
        panels[3].set_ylabel('worst drift so far [–]')
    else:
        _energy(panels[2], energy, motion.command_time)
        _drift(panels[3], energy)
    if motion.loads is not None:
        _loads(panels[4], motion)
    for axes in panels:
        axes.grid(alpha=0.3)
    for axes in panels[:-1]:
        axes.tick_params(labelbottom=False)
    panels[-1].set_xlabel('simulation time [s]')
    figure.align_ylabels(panels)
    return figure


def _legend(axes: Axes, names: Sequence[str]) -> None:
    """Name the first bodies; say how many more there are."""
    axes.axis('off')
    lines = [
        Line2D([], [], **style(index), label=name)
        for index, name in enumerate(names[:NAMED_BODIES])
    ]
    more = len(names) - NAMED_BODIES
    if more > 0:
        lines.append(Line2D([], [], **OTHERS, label=f'{more} more bodies, not named'))
    title = 'bodies' if more <= 0 else f'the first {NAMED_BODIES} of {len(names)} bodies'
    legend = axes.legend(
        handles=lines,
        title=title,
        loc='center',
        ncols=1 + (len(lines) - 1) // 6,
        handlelength=4.5,
        frameon=False,
    )
    for text in legend.get_texts():
        text.set_parse_math(False)


def _speeds(
    axes: Axes,
    motion: RecordedMotion,
    quantity: Callable[[Track], Array],
    label: str,
    nothing: str,
) -> None:
    axes.set_ylabel(label)
    speeds = [np.linalg.norm(quantity(track), axis=1) for track in motion.tracks]
    if not any(speed.any() for speed in speeds):
        _say(axes, nothing)
        axes.set_yticks([])
        return
    for index, (track, speed) in reversed(
        list(enumerate(zip(motion.tracks, speeds, strict=True)))
    ):
        axes.plot(track.twist_time, speed, **style(index))
    _calm(axes)


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


def _drift(axes: Axes, energy: EnergyHistory) -> None:
    axes.set_ylabel('worst drift so far [–]')
    kept = [i for i in range(len(LAWS)) if np.isfinite(energy.drift[:, i]).all()]
    balance = energy.balance
    if not kept and (balance is None or balance.turnover <= 0.0):
        _say(axes, 'forces of this scene change energy and momentum:\nnothing is conserved')
        axes.set_yticks([])
        return
    axes.set_yscale('log')
    names = ('rise of energy', *LAWS[1:]) if energy.may_only_fall else LAWS
    for i in kept:
        values = np.maximum(np.abs(energy.drift[:, i]), NO_DRIFT)
        axes.plot(energy.time, values, **style(i), label=names[i])
    if balance is not None and balance.turnover > 0.0:
        defect = np.maximum(np.abs(balance.defect) / balance.turnover, NO_DRIFT)
        axes.plot(balance.time, defect, **style(3), label='defect of the energy balance')
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
    if not motion.loads:
        _say(axes, NO_CONTACTS)
        axes.set_yticks([])
        return
    if not any(len(load.time) for load in motion.loads.values()):
        _say(axes, 'nothing touched')
        axes.set_yticks([])
        return
    for index, track in reversed(list(enumerate(motion.tracks))):
        load = motion.loads.get(track.name)
        if load is not None and len(load.time):
            line = style(index) | {'linestyle': 'none', 'marker': '.', 'markersize': 2.5}
            axes.plot(load.time, load.force, **line)
    axes.set_ylim(bottom=0.0)


def _key(axes: Axes) -> None:
    axes.legend(loc='best', fontsize=8, ncols=2, handlelength=4, framealpha=0.85)


def _say(axes: Axes, text: str) -> None:
    axes.text(0.5, 0.5, text, transform=axes.transAxes, ha='center', va='center', color='#555555')


def _calm(axes: Axes) -> None:
    """Do not blow up round-off: an axis spans at least a millionth of its values."""
    low, high = axes.get_ylim()
    middle, least = 0.5 * (low + high), 1e-6 * max(abs(low), abs(high), 1e-9)
    if high - low < least:
        axes.set_ylim(middle - 0.5 * least, middle + 0.5 * least)
    axes.ticklabel_format(axis='y', useOffset=False)
