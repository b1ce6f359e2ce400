# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Jumps of the velocity or of the acceleration that samples show by themselves.

    L, R     : polynomials of degree p by least squares, through m samples up to a gap between
               neighbours and through m from there on
    D_k      = R^(k) - L^(k) in the middle of the gap, k = 0, 1, 2
    E_k      = |L_p^(k) - L_{p-1}^(k)| + |R_p^(k) - R_{p-1}^(k)|    what such polynomials err by,
               or a tenth of the same one degree lower, if that is more
    a jump   : |D_k| > 6 sigma_k + 10 E_k for some k, sigma_k what noise makes of D_k

A motion that the samples resolve has D_k of the size of what degree p errs by, which is less than
E_k; where a jump lies inside of L or R, E_k is as large as D_k. So what is found stands alone
among m samples: windows become shorter, of lower degree, until four samples lie between two jumps.

The instant of a jump of the velocity is where L and R meet; of the acceleration, where L' and R'
do (`_placed`). Where they meet nowhere in the gap, both ends of it share the doubt. What takes
longer than one gap (a stop within several steps of a run) is a transition: what is in it rests on
few samples, and is told to be as wrong as it changes (`Kink`).

Not found: jumps that noise hides, that lie nearer to each other, or at the first and last two
samples. Source: tests for a change of regression, of which this is the local one: Loader, Annals
of Statistics 24 (1996) 1667.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.analysis.noise_level import noise_level
from rigid_body_sim.analysis.piecewise_spline import Break

Array = NDArray[np.float64]

NOISE = 6.0  # [-] standard deviations; at 5 one of 10^6 windows is a jump without one
MODEL = 10.0  # [-] of what two degrees differ by; at 3 motions of 1 rad per sample have jumps
# degree and samples of a window on either side, and the longest transition [samples inside]
WINDOWS = (
    (5, 6, 0),
    (5, 6, 2),
    (3, 8, 0),
    (3, 16, 0),
    (3, 32, 0),
    (4, 5, 0),
    (3, 4, 0),
    (3, 4, 2),
)
ROUNDS = 4  # of one window: jumps that others hid
CROWD = 6  # [samples] for each jump, on the mean: more are no jumps but how the samples are
INSIDE = 0.02  # [gap] that a transition begins behind its first sample
MISFIT = 2.0  # [-] of the noise
LOWER = 0.1  # [-] of what the next lower degree errs by
KINDS = 3  # value, first and second derivative
CHUNK = 1 << 14  # windows solved at once: memory


@dataclass(frozen=True, order=True)
class Kink:
    """
    A jump found in samples.

    first, last   : samples between which it lies
    breaks        : where the spline is cut
    speed, change : sizes by which first and second derivative change
    blur          : how far its instant may be off: of a velocity by noise
    apart         : whether no instant in its gap explains it: the spline is in two there
    """

    first: int
    last: int
    breaks: tuple[Break, ...]
    speed: float
    change: float
    blur: float = 0.0
    apart: bool = False

    @property
    def transition(self) -> bool:
        """Whether samples lie inside."""
        return self.last - self.first > 1


def find_kinks(
    time: Array, samples: Array, known: Sequence[Break] = (), *, rounding: Array | float = 0.0
) -> list[Kink]:
    """
    Find jumps in samples (n, d) at ascending times (n,), beside those at known instants.

        rounding : (d,) at least that is noise

    More than one for CROWD samples are none: what is quantised jumps everywhere.
    """
    edges = {0, len(time)}
    edges |= {int(np.searchsorted(time, b.instant)) for b in known}
    noise = noise_level(time, samples, sorted(edges), typical=True)
    noise = np.maximum(noise, rounding)
    found: list[Kink] = []
    for degree, count, longest in WINDOWS:
        for inside in range(min(1, longest), longest + 1):
            for _ in range(ROUNDS):
                more = _of_window(time, samples, noise, sorted(edges), degree, count, inside)
                found += more
                for kink in more:
                    edges |= {kink.first + 1, kink.last}
                if not more or len(found) * CROWD > len(time):
                    break
        if len(found) * CROWD > len(time):
            return []
    return sorted(found)


def _of_window(
    time: Array,
    samples: Array,
    noise: Array,
    edges: list[int],
    degree: int,
    count: int,
    inside: int,
) -> list[Kink]:
    """Jumps that windows of one kind show, each alone among its samples."""
    found = []
    for begin, end in pairwise(edges):
        if end - begin < 2 * count + inside:
            continue
        t, y = time[begin:end], samples[begin:end]
        sides = _sides(t, y, noise, degree, count, inside)
        size = np.linalg.norm(sides.jump, axis=2)
        ratio = np.max(size / (sides.limit + np.finfo(float).tiny), axis=0)
        while ratio.size and np.max(ratio) > 1.0:
            i = int(np.argmax(ratio))
            found.append(_placed(t, sides, i, count, inside, begin))
            ratio[max(0, i - count) : i + count + 1] = 0.0
    return found


@dataclass(frozen=True, eq=False)
class _Sides:
    """
    Both sides of each place of a window, by order of derivative.

    jump  : (3, k, d) right less left, in the middle between them
    noise : (3, k) standard deviation of that by noise
    limit : (3, k) size of a jump that is none
    """

    jump: Array
    noise: Array
    limit: Array


def _sides(
    time: Array, samples: Array, noise: Array, degree: int, count: int, inside: int
) -> _Sides:
    places = len(time) - 2 * count - inside + 1
    t = np.lib.stride_tricks.sliding_window_view(time, count)
    y = np.lib.stride_tricks.sliding_window_view(samples, count, axis=0)  # (n, d, count)
    sides = []
    middle = 0.5 * (time[count - 1 : count - 1 + places] + time[count + inside :][:places])
    origin = samples[count - 1 : count - 1 + places]  # near: differences are exact
    for start in (0, count + inside):
        values = np.empty((KINDS, places, samples.shape[1]))
        errs, spread = np.empty((KINDS, places)), np.empty((KINDS, places))
        misfit = np.zeros(places)
        for low in range(0, places, CHUNK):
            part = slice(low, min(places, low + CHUNK))
            rows = slice(start + part.start, start + part.stop)
            own = _weights(t[rows], middle[part], degree)
            less = _weights(t[rows], middle[part], degree - 1)
            local = y[rows] - origin[part, :, None]
            values[:, part] = np.einsum('kpm,pdm->kpd', own, local)
            misfit[part] = _misfit(t[rows], local, degree)
            apart = np.einsum('kpm,pdm->kpd', own - less, local)
            errs[:, part] = np.linalg.norm(apart, axis=2)
            if degree > KINDS - 1:
                lowest = _weights(t[rows], middle[part], degree - 2)
                apart = np.einsum('kpm,pdm->kpd', less - lowest, local)
                errs[:, part] = np.maximum(errs[:, part], LOWER * np.linalg.norm(apart, axis=2))
            spread[:, part] = np.sum(np.square(own), axis=2)
        sides.append((values, _around(errs), spread, misfit))
    (
        (left, left_errs, left_spread, left_misfit),
        (right, right_errs, right_spread, right_misfit),
    ) = sides
    by_noise = np.linalg.norm(noise) * np.sqrt(left_spread + right_spread)
    limit = NOISE * by_noise + MODEL * (left_errs + right_errs)
    if count > degree + 1:  # what a window cannot follow inside it is no jump at its end
        bad = np.maximum(left_misfit, right_misfit) > MISFIT * np.linalg.norm(noise)
        limit[:, bad] = np.inf
    return _Sides(right - left, by_noise, limit)


def _around(errs: Array) -> Array:
    """Largest of an error and those beside it: that of one window may pass through zero."""
    padded = np.pad(errs, ((0, 0), (1, 1)))
    beside = np.minimum(padded[:, :-2], padded[:, 2:])  # both: one of them may hold the jump
    return np.maximum(errs, beside)


def _weights(time: Array, at: Array, degree: int) -> Array:
    """Weights (3, p, m) of samples in value and derivatives at `at` (p,) of their polynomial."""
    span = (time[:, -1] - time[:, 0])[:, None]
    x = (time - at[:, None]) / span
    powers = x[:, :, None] ** np.arange(degree + 1)
    q, r = np.linalg.qr(powers)
    coefficients = np.linalg.solve(r, np.swapaxes(q, 1, 2))  # (p, degree + 1, m)
    found = np.zeros((KINDS, *time.shape))
    for order, factor in ((0, 1.0), (1, 1.0), (2, 2.0)):
        if order <= degree:
            found[order] = factor * coefficients[:, order] / span**order
    return found


def _misfit(time: Array, samples: Array, degree: int) -> Array:
    """Root of the mean square (p,) of what polynomials leave of samples (p, d, m)."""
    x = (time - time[:, :1]) / (time[:, -1:] - time[:, :1])
    q, _ = np.linalg.qr(x[:, :, None] ** np.arange(degree + 1))
    rest = samples - np.einsum('pmi,pni,pdn->pdm', q, q, samples, optimize=True)
    free = max(1, time.shape[1] - degree - 1)
    return np.sqrt(np.sum(np.square(rest), axis=(1, 2)) / free)


def _placed(time: Array, sides: _Sides, i: int, count: int, inside: int, begin: int) -> Kink:
    """Say where in its gap a jump is, and what jumps."""
    first, last = i + count - 1, i + count + inside
    d0, d1, d2 = sides.jump[:, i]
    speed, change = float(np.linalg.norm(d1)), float(np.linalg.norm(d2))
    start, stop = float(time[first]), float(time[last])
    if inside:
        breaks = (
            Break(start + INSIDE * float(time[first + 1] - start), 0),
            Break(stop - INSIDE * float(stop - time[last - 1]), 0),
        )
        return Kink(first + begin, last + begin, breaks, speed, change)
    half, middle = 0.5 * (stop - start), 0.5 * (start + stop)
    limit = sides.limit[:, i]
    # R - L at `middle - s`: d0 - d1 s + d2 s^2 / 2; its rate: d1 - d2 s
    s = float(np.clip(d1 @ d2 / max(d2 @ d2, np.finfo(float).tiny), -half, half))
    rate, value = d1 - d2 * s, d0 - d1 * s + 0.5 * d2 * s * s
    if np.linalg.norm(rate) <= limit[1] and np.linalg.norm(value) <= limit[0]:
        blur = float(limit[1]) / NOISE / max(change, np.finfo(float).tiny)
        parts = (Break(middle - s, 1),)
        return Kink(first + begin, last + begin, parts, half * change, change, min(blur, half))
    s = 0.0
    for _ in range(8):  # Newton: its curvature is small beside the jump
        rate = d1 - d2 * s
        value = d0 - d1 * s + 0.5 * d2 * s * s
        s += float(value @ rate / max(rate @ rate, np.finfo(float).tiny))
        s = float(np.clip(s, -half, half))
    speed = float(np.linalg.norm(rate))
    if np.linalg.norm(value) > limit[0]:
        speed = max(speed, float(np.linalg.norm(d0)) / (2.0 * half))
        parts = (Break(middle, -1),)
        return Kink(first + begin, last + begin, parts, speed, change, apart=True)
    blur = float(sides.noise[0, i]) / max(speed, np.finfo(float).tiny)
    return Kink(first + begin, last + begin, (Break(middle - s, 0),), speed, change, blur)
