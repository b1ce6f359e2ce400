# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
First and second derivatives of noisy samples, the bandwidth that suits them, and how wrong they
are.

    error^2 = sigma^2 v + b^2
        sigma : noise of the samples (`noise_level`)
        v     : what the linear map makes of white noise of variance one, from noise drawn with a
                fixed seed
        b     : what the spline cannot follow: its distance to the judge, of a degree two higher,
                less the share of noise in that distance

The bandwidth is the one with the least estimated error of the second derivative, of a ladder that
goes down from the samples themselves. Samples that are exact but for rounding are not smoothed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.analysis.noise_level import noise_level
from rigid_body_sim.analysis.piecewise_spline import (
    DEGREE,
    FEWEST,
    Break,
    End,
    Layout,
    Spline,
    Undetermined,
    cut,
    evenly,
    orders,
    spans_of,
    with_fewer,
)

Array = NDArray[np.float64]

RUNG = 2.0**-0.5  # [-] from one bandwidth of the ladder to the next
TINY = np.finfo(float).tiny
EPSILON = float(np.finfo(float).eps)
ROUNDING = 100 * EPSILON  # [-] of the largest sample: such noise is rounding, not white
HOPELESS = 30.0  # [-] mean square of what is lost, in that of the best: further down is no better
TRIES = 3  # hopeless rungs in a row before the ladder is left
DRAWS = 24  # of noise, for each sample
MOST_DRAWN = 400_000  # numbers drawn in all
SEED = 20_260_101  # of the noise that is drawn: the same samples give the same bands
NEVER = (np.inf, np.inf, None)  # estimated errors of what cannot be
DOUBT = 1.5  # a distance to the judge below so many times that by noise tells of noise alone,
DOUBT_UNSMOOTHED = 4.0
MORE_DOUBT, MOST_DOUBT = 0.02, 9.0  # the more, the noisier the judge is beside the spline
WINDOW = 3.0  # [knots] over which what is lost is averaged
SPREADS = 0.43  # [-] to the next sample: largest root of the quintic B-spline at whole numbers
NEIGHBOURS = 3  # gaps on each side that share a B-spline with one


@dataclass(frozen=True, eq=False)
class Fit:
    """
    One spline through samples, and what is known of its errors; lists are by order of derivative.

    own, judge   : (n, d) each; values are as the samples
    response     : (n,) variance that noise of variance one has in the derivative
    disagreement : (n,) the same in the distance of own and judge
    free         : coefficients that are free
    judged       : (n,) whether the judge is another spline there
    piece, span  : (n,) number of the piece in which a sample lies, and how long it lasts
    share        : (n,) free coefficients for each sample
    fading       : (n - 1,) share of an error at a sample that goes on to the next
    smooths      : whether it has fewer coefficients than samples
    """

    own: list[Array]
    judge: list[Array]
    response: list[Array]
    disagreement: list[Array]
    free: int
    judged: NDArray[np.bool_]
    piece: NDArray[np.int64]
    span: Array
    share: Array
    fading: Array
    smooths: bool


def fit(layout: Layout, samples: Array, fraction: float, fewest: int = FEWEST) -> Fit:
    """
    Fit with so many coefficients for each sample, and so many at least in each piece; Undetermined
    where that cannot be.
    """
    share = evenly(spans_of(layout.time), fraction * len(samples))
    chosen = [
        orders(
            piece,
            float(np.sum(share[piece.first : piece.end])),
            fewest,
            through=fraction == 1.0,
        )
        for piece in layout.pieces
    ]
    counts = [piece.samples for piece in layout.pieces]
    own, above = (Spline(layout, [pair[i] for pair in chosen]) for i in (0, 1))
    noise = _drawn(len(samples))
    own_noise = own.derivatives(noise, tied=False)
    judge_noise = above.derivatives(noise, tied=False)
    origin = samples[0]  # what lies near zero is rounded less
    at_samples = [spline.derivatives(samples - origin) for spline in (own, above)]
    for derivatives in at_samples:
        derivatives[0] += origin
    return Fit(
        at_samples[0],
        at_samples[1],
        [np.mean(np.square(n), axis=1) for n in own_noise],
        [np.mean(np.square(a - b), axis=1) for a, b in zip(own_noise, judge_noise)],
        own.free,
        np.repeat([pair[0].judged for pair in chosen], counts),
        np.repeat(np.arange(len(counts)), counts),
        np.repeat([piece.finish - piece.begin for piece in layout.pieces], counts),
        share * (max(1, own.free) / float(np.sum(share))),
        _fading(layout),
        fraction < 1.0,
    )


def _drawn(count: int) -> Array:
    draws = int(max(4, min(DRAWS, MOST_DRAWN // count)))
    return np.random.default_rng(SEED).standard_normal((count, draws))


def fractions(layout: Layout) -> Iterator[float]:
    """Ladder of coefficients for each sample, from one down to a parabola in each piece."""
    longest = max(piece.samples for piece in layout.pieces)
    fraction = 1.0
    while fraction * longest > FEWEST / RUNG:
        yield fraction
        fraction *= RUNG
    yield FEWEST / longest


def noise_of(layout: Layout, samples: Array) -> Array:
    """Noise (d,) of samples: at least the rounding of what they change by."""
    edges = [piece.first for piece in layout.pieces] + [len(samples)]
    level = noise_level(layout.time, samples, edges)
    return np.maximum(level, 0.25 * EPSILON * np.ptp(samples, axis=0))


def only_rounding(samples: Array, noise: Array) -> bool:
    """Whether noise (d,) may be rounding, which is not white as it adds up in a run."""
    return bool(np.all(noise <= ROUNDING * np.max(np.abs(samples), axis=0)))


def follow(
    time: Array,
    samples: Array,
    breaks: Sequence[Break],
    ends: Sequence[End] = (),
    *,
    bandwidth: float | None = None,
    turns: bool = False,
) -> tuple[Fit, Layout, Array, tuple[float, ...]]:
    """
    Follow samples (n, d) with the spline that suits them.

        bandwidth : [1 / unit of the times] None: found
        turns     : whether the samples are quaternions, whose columns share one noise
        returns   : the spline, its layout, the noise (d,), and the instants of jumps given up
    """
    fraction = None
    if bandwidth is not None:
        borne = np.minimum(1.0, 2.0 * bandwidth * np.diff(time))  # by the samples
        fraction = 1.0 if np.all(borne == 1.0) else float(np.sum(borne)) / len(time)
    layout = cut(time, breaks, ends)
    given_up = {b.instant for b in layout.dropped}
    while True:
        noise = noise_of(layout, samples)
        if turns:
            noise = np.full_like(noise, np.sqrt(np.mean(np.square(noise))))
        try:
            found = choose(layout, samples, noise, fraction=fraction)
        except Undetermined:
            if not layout.breaks:
                raise
            fewer = with_fewer(layout)
            given_up |= {b.instant for b in set(layout.breaks) - set(fewer) if b.continuity <= 1}
            layout = cut(time, fewer, ends)
            continue
        return found, layout, noise, tuple(sorted(given_up))


def choose(layout: Layout, samples: Array, noise: Array, *, fraction: float | None = None) -> Fit:
    """
    Fit with the bandwidth that has the least estimated error of the second derivative.

        noise    : (d,) standard deviations of the samples' columns
        fraction : coefficients for each sample; None: found
    """
    if fraction is not None or only_rounding(samples, noise):
        return _fit_if_possible(layout, samples, 1.0 if fraction is None else fraction)
    tried: dict[tuple[int, int], tuple[float, float, Fit | None]] = {}
    ladder = list(fractions(layout))

    def look(rung: int, fewest: int) -> tuple[float, float, Fit | None]:
        """Estimated mean square, and that of what is lost, of one choice."""
        place = rung, fewest
        if place not in tried and 0 <= rung < len(ladder) and fewest >= FEWEST:
            tried[place] = _judged_fit(layout, samples, noise, ladder[rung], fewest)
        return tried.get(place, NEVER)

    best, hopeless = (0, DEGREE + 1), 0
    for rung in range(len(ladder)):
        total, lost, _ = look(rung, DEGREE + 1)
        least = look(*best)[0]
        best = (rung, DEGREE + 1) if total < least else best
        hopeless = hopeless + 1 if lost > HOPELESS * least else 0
        if hopeless == TRIES:
            break
    while True:
        rung, fewest = best
        near = [best, (rung, fewest - 1), (rung + 1, fewest), (rung - 1, fewest)]
        better = min(near, key=lambda place: look(*place)[0])
        if better == best:
            break
        best = better
    found = look(*best)[2]
    if found is None:
        raise Undetermined('the samples do not determine the spline')
    return found


def _judged_fit(
    layout: Layout, samples: Array, noise: Array, fraction: float, fewest: int
) -> tuple[float, float, Fit | None]:
    try:
        found = fit(layout, samples, fraction, fewest)
    except Undetermined:
        return NEVER
    lost = lost_square(found, 2, noise)
    lost += float(np.mean(np.square(blind_spots(found, layout.time, found.own[2]))))
    return lost + float(np.mean(noise_square(found, 2, noise))), lost, found


def _fit_if_possible(layout: Layout, samples: Array, fraction: float) -> Fit:
    """Fit, with fewer coefficients where that many are not determined."""
    for rung in fractions(layout):
        if rung > fraction * RUNG and rung < 1.0:
            continue
        try:
            return fit(layout, samples, min(rung, fraction))
        except Undetermined:
            continue
    return fit(layout, samples, 0.0)


def noise_square(found: Fit, order: int, noise: Array) -> Array:
    """Mean square (n,) of what noise does to a derivative, all columns together."""
    return found.response[order] * np.sum(np.square(noise))


def lost_square(found: Fit, order: int, noise: Array) -> float:
    """Mean square of what the spline cannot follow in a derivative."""
    distance = np.square(found.own[order] - found.judge[order])
    by_noise = found.disagreement[order][:, None] * np.square(noise)
    return float(np.mean(np.sum(_lost(found, distance - by_noise), axis=1)))


def _ratio(found: Fit) -> Array:
    """How much noisier the distance to the judge is than the second derivative, a column."""
    return (found.disagreement[2] / np.maximum(found.response[2], TINY))[:, None]


def _doubt(found: Fit) -> Array:
    """How many times the distance by noise is taken for noise, a column."""
    if not found.smooths:  # ends of a spline through the samples: few, and as noisy as its judge
        return np.full((len(found.span), 1), DOUBT_UNSMOOTHED)
    return np.clip(DOUBT + MORE_DOUBT * _ratio(found), DOUBT, MOST_DOUBT)


def _lost(found: Fit, excess: Array) -> Array:
    """Mean square of what is lost about each sample, from squares of distances less noise."""
    if not found.smooths:
        return np.maximum(excess, 0.0)
    return np.maximum(_averaged(excess, found.share), 0.0)


def _fading(layout: Layout) -> Array:
    """
    Share (n - 1,) of an error at one sample that the spline through them has at the next.

    SPREADS where samples are even. Beside longer gaps less of it is lost: samples that lie close
    together are one to it, what an interval does wrong goes on over as much time as it lasts.
    """
    gaps = np.diff(layout.time)
    around = np.lib.stride_tricks.sliding_window_view(
        np.pad(gaps, NEIGHBOURS, mode='edge'), 2 * NEIGHBOURS + 1
    )
    fading = SPREADS ** (gaps / np.max(around, axis=1))
    for piece, b in zip(layout.pieces[1:], layout.breaks):
        if b.continuity < 0 and 0 < piece.first < len(layout.time):
            fading[piece.first - 1] = 0.0
    return fading


def _spread(lost: Array, fading: Array) -> Array:
    """
    Mean squares (n, 3) of what is lost, with what spreads to each sample from those beside it.

    Where samples are uneven the judge errs as the spline does, and their distance passes through
    zero where the error does not.
    """
    spread, share = lost.copy(), np.square(fading)
    for i in range(1, len(spread)):
        np.maximum(spread[i], share[i - 1] * spread[i - 1], out=spread[i])
    for i in range(len(spread) - 2, -1, -1):
        np.maximum(spread[i], share[i] * spread[i + 1], out=spread[i])
    return spread


@dataclass(frozen=True, eq=False)
class Errors:
    """
    How wrong a quantity (n, 3) is.

    deviation : (n, 3) one standard deviation of each component
    rms       : root of the mean square of the vector's error
    largest   : where the error is largest
    """

    deviation: Array
    rms: float
    largest: float


def errors(
    found: Fit,
    own: Array,
    judge: Array,
    by_noise: Array,
    in_distance: Array,
    blind: Array,
) -> Errors:
    """
    Join what noise does to a quantity with what the spline cannot follow.

        own, judge  : (n, 3) the quantity from the spline and from its judge
        by_noise    : (n, 3) variance of its components by noise
        in_distance : (n, 3) variance by noise of the distance of own and judge
        blind       : (n, 3) what it may be wrong by besides: where a piece has no judge
                      (`blind_spots`)
    """
    square = np.square(own - judge)
    lost = _lost(found, square - _doubt(found) * in_distance)
    if not found.smooths:
        lost = _spread(lost, found.fading)
    lost += np.square(blind)
    rms = np.sqrt(np.mean(np.sum(lost + by_noise, axis=1)))
    # the largest of so many normal numbers, on top of what is lost
    reach = np.sqrt(2.0 * np.log(3.0 * len(own)))
    peak = np.sqrt(np.sum(lost, axis=1)) + reach * np.sqrt(np.max(by_noise, axis=1))
    return Errors(np.sqrt(lost + by_noise), float(rms), float(np.max(peak)))


def blind_spots(found: Fit, time: Array, second: Array) -> Array:
    """
    How far a second derivative (n, 3) may stray where its piece has no judge, zero elsewhere.

    Such a piece is a parabola: of a steady change of the second derivative, taken from the pieces
    nearby, it may be wrong by two thirds of that over the piece, at its far end.
    """
    strays = np.zeros_like(second)
    inside = np.flatnonzero(found.judged[1:] & found.judged[:-1])
    blind = np.flatnonzero(~found.judged)
    if not len(inside) or not len(blind):
        return strays
    rates = np.abs(np.diff(second, axis=0)[inside] / np.diff(time)[inside, None])
    after = np.clip(np.searchsorted(inside, blind), 0, len(inside) - 1)
    near = np.maximum(rates[after], rates[np.maximum(after - 1, 0)])
    strays[blind] = near * found.span[blind, None] * 2.0 / 3.0
    return strays


def _averaged(values: Array, share: Array) -> Array:
    """Running means (n, 3) over WINDOW coefficients and the samples beside, fewer at the ends."""
    sums = np.concatenate(
        (np.zeros((1, values.shape[1])), np.cumsum(share[:, None] * values, axis=0))
    )
    edges = np.concatenate(([0.0], np.cumsum(share)))
    at, count = np.arange(len(values)), len(values)
    middle = 0.5 * (edges[1:] + edges[:-1])
    low = np.searchsorted(middle, edges[:-1] - 0.5 * WINDOW)
    high = np.searchsorted(middle, edges[1:] + 0.5 * WINDOW)
    low = np.clip(np.minimum(low, at - 1), 0, count)
    high = np.clip(np.maximum(high, at + 2), 0, count)
    return (sums[high] - sums[low]) / (edges[high] - edges[low])[:, None]
