# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Where the bodies went: in space, in the plane they stay in, or, where none travels, how they turn.

In the last case the picture shows the path of the tip of one body axis on the unit sphere, for
each body the axis that sweeps farthest.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec
from numpy.typing import NDArray

from rigid_body_sim.physics.model import rotation as so3
from rigid_body_sim.view.line_styles import NAMED_BODIES, style
from rigid_body_sim.view.recorded_motion import RecordedMotion, Track

Array = NDArray[np.float64]

FLAT = 1e-3  # [-] a direction with less than this part of the extent of the motion is not drawn
SQUEEZED = 0.2  # [-] of the widest span: a narrower one gets a scale of its own
RESTS = 1e-3  # [-] of the scene, [-] of a quaternion: less is no motion to look at
PLANES = ((0, 2), (0, 1), (1, 2))  # x-z first: gravity is along z
AXES = 'xyz'


@dataclass(frozen=True, eq=False)
class Path:
    """
    One curve to draw.

    name   : legend
    points : (k, 3) [m], or [-] on the unit sphere
    """

    name: str
    points: Array


def has_trajectory(motion: RecordedMotion) -> bool:
    """Whether a body goes anywhere, or turns, by more than round-off and the give of contacts."""
    travel, turn = _ways(motion)
    across = float(np.ptp(np.vstack([t.position[0] for t in motion.tracks]), axis=0).max())
    return travel > RESTS * max(across, RESTS) or turn > RESTS


def _ways(motion: RecordedMotion) -> tuple[float, float]:
    """Largest travel along an axis [m] and largest change of a quaternion [-]."""
    travel = max(float(np.ptp(track.position, axis=0).max()) for track in motion.tracks)
    turn = max(float(np.ptp(track.orientation, axis=0).max()) for track in motion.tracks)
    return travel, turn


def draw_trajectories(figure: Figure, place: SubplotSpec, motion: RecordedMotion) -> list[str]:
    """Draw the paths and return the names for the legend, one per body."""
    travel, turn = _ways(motion)
    if travel > 0.0 or turn == 0.0:
        paths = [Path(track.name, track.position) for track in motion.tracks]
        _draw(figure, place, paths, title='trajectories of the centres of mass', unit='m')
    else:
        paths = [_axis_path(track) for track in motion.tracks]
        _draw(
            figure,
            place,
            paths,
            title='no body travels: directions of body axes',
            unit='–',
            sphere=True,
        )
    return [path.name for path in paths]


def _axis_path(track: Track) -> Path:
    """Tip of the body axis that sweeps farthest."""
    tips = so3.matrix_from_quaternion(track.orientation)  # columns: the body axes in the world
    sweep = np.ptp(tips, axis=0).sum(axis=0)
    axis = int(np.argmax(sweep))
    return Path(f'{track.name}: {AXES[axis]} axis', tips[:, :, axis])


def _draw(
    figure: Figure,
    place: SubplotSpec,
    paths: list[Path],
    *,
    title: str,
    unit: str,
    sphere: bool = False,
) -> None:
    plane = None if sphere else _plane(paths)
    axes = figure.add_subplot(place, projection='3d' if plane is None else None)
    directions = [0, 1, 2] if plane is None else list(plane)
    for index, path in reversed(list(enumerate(paths))):
        columns = path.points[:, directions].T
        line: dict[str, Any] = style(index) | ({'linewidth': 0.8} if sphere else {})
        axes.plot(*columns, **line)
        if index < NAMED_BODIES:
            _mark_ends(axes, columns, style(index)['color'])
    for name, direction in zip('xyz', directions, strict=False):
        getattr(axes, f'set_{name}label')(f'{AXES[direction]} [{unit}]')
    if sphere:
        _globe(axes)
    extent = np.array([[-1.0] * 3, [1.0] * 3]) if sphere else _extent(paths)
    alike = (_scale_space if plane is None else _scale_plane)(axes, extent[:, directions])
    note = '' if alike else ', axes scaled differently'
    axes.set_title(f'{title}{note}\n○ first, ■ last recorded instant', fontsize=10)


def _mark_ends(axes: Axes, columns: Array, color: str) -> None:
    axes.plot(*columns[:, :1], 'o', color=color, markersize=6, markerfacecolor='white', zorder=4)
    axes.plot(*columns[:, -1:], 's', color=color, markersize=5, zorder=4)


def _globe(axes: Axes) -> None:
    """Three great circles, to see the sphere by."""
    angle = np.linspace(0.0, 2.0 * np.pi, 181)
    circle = (np.cos(angle), np.sin(angle), np.zeros_like(angle))
    for turned in range(3):
        axes.plot(*np.roll(circle, turned, axis=0), color='#BBBBBB', linewidth=0.6, zorder=1)


def _extent(paths: list[Path]) -> Array:
    """Smallest box around all paths: (2, 3)."""
    low = np.min([path.points.min(axis=0) for path in paths], axis=0)
    high = np.max([path.points.max(axis=0) for path in paths], axis=0)
    return np.stack([low, high])


def _plane(paths: list[Path]) -> tuple[int, int] | None:
    """Choose the coordinate plane that holds the motion; None where it needs all three."""
    spans = np.ptp(_extent(paths), axis=0)
    wide = [i for i in range(3) if spans[i] > FLAT * spans.max()]
    return next((plane for plane in PLANES if set(wide) <= set(plane)), None)


def _scale_plane(axes: Axes, extent: Array) -> bool:
    """Scale both directions alike unless one would be squeezed; tell whether they are."""
    spans = np.ptp(extent, axis=0)
    axes.grid(alpha=0.3)
    axes.margins(0.06)
    alike = spans.min() > SQUEEZED * spans.max() or spans.min() == 0.0
    if alike:
        axes.set_aspect('equal', adjustable='datalim')
    return bool(alike)


def _scale_space(axes: Any, extent: Array) -> bool:  # matplotlib gives such axes no types
    """Scale all directions alike unless one would be squeezed; tell whether they are."""
    spans, middle = np.ptp(extent, axis=0), extent.mean(axis=0)
    alike = spans.min() > SQUEEZED * spans.max()
    axes.set_box_aspect(tuple(spans) if alike else (1.0, 1.0, 1.0), zoom=0.8)
    for name, m, span in zip('xyz', middle, spans, strict=True):
        getattr(axes, f'set_{name}lim')(m - 0.53 * span, m + 0.53 * span)
        axes.tick_params(axis=name, labelsize=9)
    axes.locator_params(nbins=6)
    return bool(alike)
