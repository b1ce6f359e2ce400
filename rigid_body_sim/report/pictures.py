# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Work–precision pictures, one for each problem: error against cost, both logarithmic, PNG and SVG.

Lower is more accurate, left is cheaper. The broad band joins the points than which none is as
accurate for less, closed forms apart: those are stars.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes as Plot
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from rigid_body_sim.recording.new_output import replacing
from rigid_body_sim.report import labels
from rigid_body_sim.report.series import Series, axes_of, front_of, series_of

SIZE = (9.0, 6.4)  # [inch]
DOTS_PER_INCH = 120
BAND = '#F3E6A8'
RAISED = str.maketrans('-0123456789', '⁻⁰¹²³⁴⁵⁶⁷⁸⁹')
ROOM = 3.5  # [-] factor by which the axes reach beyond the points


def write(report: Mapping[str, Any], folder: Path) -> list[Path]:
    """Draw every problem of a report; returns the files."""
    files = []
    for problem in report['problems']:
        figure = picture(problem)
        if figure is None:
            continue
        for suffix in ('png', 'svg'):
            path = folder / f'{problem["name"]}.{suffix}'
            with (
                replacing(path) as part,
                matplotlib.rc_context({'svg.fonttype': 'none', 'svg.hashsalt': problem['name']}),
            ):
                figure.savefig(
                    part,
                    format=suffix,
                    dpi=DOTS_PER_INCH,
                    metadata={'Date': None} if suffix == 'svg' else None,
                )
            files.append(path)
    return files


def picture(problem: Mapping[str, Any]) -> Figure | None:
    """Draw one problem; None where no point came out."""
    curves = series_of(problem)
    if not curves:
        return None
    axes = axes_of(problem)
    figure = Figure(figsize=SIZE, layout='constrained')
    plot = figure.add_subplot()
    figure.suptitle(problem['title'], fontsize=13, fontweight='bold', parse_math=False)
    plot.set_title(
        textwrap.fill(problem['description'], 112),
        fontsize=8.5,
        color='#333333',
        parse_math=False,
    )
    plot.set_xscale('log')
    plot.set_yscale('log')
    plot.set_xlabel(axes.x)
    plot.set_ylabel(axes.y)
    _front(plot, front_of(problem))
    for curve in curves[::-1]:
        _draw(plot, curve)
    _frame(plot, curves)
    _legend(plot, curves)
    figure.draw_without_rendering()
    _name(plot, curves)
    return figure


def _front(plot: Plot, front: Sequence[tuple[float, float]]) -> None:
    if len(front) > 1:
        x, y = zip(*front, strict=True)
        plot.plot(x, y, color=BAND, linewidth=11, solid_capstyle='round', zorder=1)
    elif front:
        plot.plot(*front[0], 'o', color=BAND, markersize=15, zorder=1)


def _draw(plot: Plot, curve: Series) -> None:
    plot.plot(
        curve.x,
        curve.y,
        color=curve.color,
        linestyle='-' if curve.ours else (0, (4, 2)),
        linewidth=1.8 if curve.stands_out else 0.8,
        marker=curve.mark,
        markersize=(11.0 if curve.mark == '*' else 6.0) if curve.stands_out else 3.5,
        markerfacecolor=curve.color if curve.ours else 'white',
        markeredgecolor=curve.color,
        zorder=(4 if curve.ours else 3) if curve.stands_out else 2,
    )


def _frame(plot: Plot, curves: Sequence[Series]) -> None:
    x = [value for curve in curves for value in curve.x]
    y = [value for curve in curves for value in curve.y]
    plot.set_xlim(min(x) / ROOM, max(x) * ROOM)
    plot.set_ylim(min(y) / ROOM, max(y) * ROOM)
    for axis in (plot.xaxis, plot.yaxis):
        axis.set_major_locator(LogLocator(numticks=12))
        axis.set_major_formatter(FuncFormatter(_power))
        axis.set_minor_formatter(NullFormatter())
    plot.grid(which='major', color='#DDDDDD', linewidth=0.6)
    plot.set_axisbelow(True)
    for side in ('top', 'right'):
        plot.spines[side].set_visible(False)


def _power(value: float, _place: int | None = None) -> str:
    """Write a power of ten without the typesetter of formulas, which takes its time."""
    return '10' + str(round(math.log10(value))).translate(RAISED)


def _legend(plot: Plot, curves: Sequence[Series]) -> None:
    """What colour, mark and band mean; the curves bear their own names."""
    ours = Line2D([], [], color='#0072B2', marker='o', linewidth=1.8)
    peers = Line2D([], [], color='black', marker='s', markerfacecolor='white', linestyle='--')
    band = Line2D([], [], color=BAND, linewidth=9)
    handles, words = [ours], ['rigid_body_sim']
    if any(not curve.ours for curve in curves):
        handles.append(peers)
        words.append('other engines (pale: their other methods)')
    if plot.lines and plot.lines[0].get_color() == BAND:
        handles.append(band)
        words.append('none as accurate for less (without closed forms)')
    plot.figure.legend(
        handles,
        words,
        loc='outside lower center',
        ncols=3,
        frameon=False,
        fontsize=8,
        columnspacing=1.2,
    )


def _name(plot: Plot, curves: Sequence[Series]) -> None:
    """Write the names of the curves beside them."""
    named = [index for index, curve in enumerate(curves) if curve.stands_out]
    texts = [
        plot.text(
            curves[index].x[-1],
            curves[index].y[-1],
            curves[index].label,
            color=curves[index].color,
            fontsize=9,
            ha='center',
            va='center',
            zorder=5,
            fontweight='bold' if curves[index].ours else 'normal',
        )
        for index in named
    ]
    extents = [text.get_window_extent() for text in texts]
    field = plot.get_window_extent()
    pixels = [plot.transData.transform(np.column_stack([curve.x, curve.y])) for curve in curves]
    places = labels.place(
        pixels,
        [(box.width, box.height) for box in extents],
        named,
        (field.x0, field.y0, field.x1, field.y1),
    )
    back = plot.transData.inverted()
    for text, place in zip(texts, places, strict=True):
        x, y = back.transform((place.x, place.y))
        text.set_position((x, y))
