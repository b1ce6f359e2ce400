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
                less the share of noise in that distance; and what it misses of the samples
                themselves beyond their noise, times how fast it changes at least (`missed`)

The bandwidth is the one with the least estimated error of the second derivative, of a ladder that
goes down from the samples themselves. Samples that are exact but for rounding are not smoothed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.analysis.kinks import Kink, find_kinks
from rigid_body_sim.analysis.noise_level import local_level, noise_level, quantum
from rigid_body_sim.analysis.piecewise_spline import (
    BEFORE,
    DEGREE,
    FEWEST,
    NEAR,
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
SHORTEST = 5  # [samples] over which residuals are averaged
UNLIKE_NOISE = 8.0  # [standard deviation] of a mean square of residuals: more tells of motion
STEEP = 2.0  # [standard deviation by noise] that a velocity may stray untold
MERGED = 8  # [samples] between stretches that are told as one
ALIKE = 4.0  # [distance to the judge] that an error may be beside a jump
UNEVEN = 16.0  # [eps] of the largest sample: rounding that adds up in a run
ROUGH = 6.0  # [-] of the noise: differences that are larger come of what is not smooth
ROUNDED_TICK = 12.0**-0.5  # [tick] of an instant that is only known to lie in one
NEIGHBOURS = 3  # gaps on each side that share a B-spline with one


@dataclass(frozen=True, eq=False)
class Fit:
    """
    One spline through samples, and what is known of its errors; lists are by order of derivative.

    own, judge   : (n, d) each; values are as the samples
    residual     : (n, d) samples less the spline
    response     : (n,) variance that noise of variance one has in the derivative
    disagreement : (n,) the same in the distance of own and judge
    free         : coefficients that are free
    judged       : (n,) whether the judge is another spline there
    piece, span  : (n,) number of the piece in which a sample lies, and how long it lasts
    share        : (n,) free coefficients for each sample
    fading       : (n - 1,) share of an error at a sample that goes on to the next
    rough        : (n,) variance of each column that differences beside a sample show beyond noise,
                   where the spline goes through the samples (`roughness`)
    smooths      : whether it has fewer coefficients than samples
    """

    own: list[Array]
    judge: list[Array]
    residual: Array
    response: list[Array]
    disagreement: list[Array]
    free: int
    judged: NDArray[np.bool_]
    piece: NDArray[np.int64]
    span: Array
    share: Array
    fading: Array
    rough: Array
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
        samples - at_samples[0][0],
        [np.mean(np.square(n), axis=1) for n in own_noise],
        [np.mean(np.square(a - b), axis=1) for a, b in zip(own_noise, judge_noise)],
        own.free,
        np.repeat([pair[0].judged for pair in chosen], counts),
        np.repeat(np.arange(len(counts)), counts),
        np.repeat([piece.finish - piece.begin for piece in layout.pieces], counts),
        share * (max(1, own.free) / float(np.sum(share))),
        _fading(layout),
        np.zeros(len(samples)),
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


def noise_of(
    layout: Layout, samples: Array, *, rounding: Array | float = 0.0, turns: bool = False
) -> Array:
    """
    Noise (d,) of samples: at least the rounding of what they change by.

    rounding : (d,) at least that is noise
    turns    : whether they are quaternions, whose columns share one noise: that of unit vectors
    """
    level, _ = _level(layout, samples, turns)
    level = np.maximum(level, rounding)
    if not turns:
        return np.maximum(level, 0.25 * EPSILON * np.ptp(samples, axis=0))
    least = 0.25 * EPSILON * float(np.any(np.ptp(samples, axis=0)))
    return np.full_like(level, max(least, float(np.sqrt(np.mean(np.square(level))))))


def _level(layout: Layout, samples: Array, turns: bool) -> tuple[Array, bool]:
    """Noise by differences, and whether samples but for few places are exact (`local_level`)."""
    edges = [piece.first for piece in layout.pieces] + [len(samples)]
    level = noise_level(layout.time, samples, edges)
    if only_rounding(samples, level, turns=turns):
        return level, False
    typical = noise_level(layout.time, samples, edges, typical=True)
    if np.linalg.norm(typical) > ROUNDING * np.max(np.abs(samples)):
        return level, False
    return np.maximum(typical, EPSILON * np.max(np.abs(samples)) / 4.0), True


def only_rounding(samples: Array, noise: Array, *, turns: bool = False) -> bool:
    """Whether noise (d,) may be rounding, which is not white as it adds up in a run."""
    return bool(np.all(noise <= ROUNDING * _sizes(samples, turns)))


def _sizes(samples: Array, turns: bool) -> Array:
    """Size (d,) of what is rounded: columns of a quaternion are of a unit vector."""
    sizes = np.max(np.abs(samples), axis=0)
    return np.full_like(sizes, np.max(sizes)) if turns else sizes


@dataclass(frozen=True, eq=False)
class Followed:
    """
    Samples with the spline that follows them.

    noise    : (d,) of the samples' columns
    given_up : instants of jumps that the samples do not tell apart
    kinks    : jumps that were not known, found in the samples
    """

    fit: Fit
    layout: Layout
    noise: Array
    given_up: tuple[float, ...]
    kinks: tuple[Kink, ...]


def follow(
    time: Array,
    samples: Array,
    breaks: Sequence[Break],
    ends: Sequence[End] = (),
    *,
    bandwidth: float | None = None,
    turns: bool = False,
) -> Followed:
    """
    Follow samples (n, d) with the spline that suits them, cut at breaks and where they jump.

        bandwidth : [1 / unit of the times] None: found
        turns     : whether the samples are quaternions, whose columns share one noise
    """
    fraction = None
    if bandwidth is not None:
        borne = np.minimum(1.0, 2.0 * bandwidth * np.diff(time))  # by the samples
        fraction = 1.0 if np.all(borne == 1.0) else float(np.sum(borne)) / len(time)
    known = cut(time, breaks, ends)
    edges = [piece.first for piece in known.pieces] + [len(samples)]
    steps = quantum(samples, noise_level(time, samples, edges)) / np.sqrt(12.0)
    rounding = np.maximum(EPSILON * _sizes(samples, turns), steps)
    kinks = find_kinks(time, samples, known.breaks, rounding=rounding)
    layout = cut(time, [*breaks, *(b for kink in kinks for b in kink.breaks)], ends)
    given_up = {b.instant for b in layout.dropped}
    while True:
        noise = noise_of(layout, samples, rounding=steps, turns=turns)
        exact = only_rounding(samples, noise, turns=turns) or (
            _level(layout, samples, turns)[1] and not np.any(steps)
        )
        if exact and fraction is None:
            fraction = 1.0
        try:
            found = choose(layout, samples, noise, fraction=fraction)
        except Undetermined:
            if not layout.breaks:
                raise
            fewer = with_fewer(layout)
            given_up |= {b.instant for b in set(layout.breaks) - set(fewer) if b.continuity <= 1}
            layout = cut(time, fewer, ends)
            continue
        if not found.smooths:
            found = replace(found, rough=_roughness(layout, samples, noise))
        _from_there_on(found, time, kinks, breaks)
        return Followed(found, layout, noise, tuple(sorted(given_up)), tuple(kinks))


def _roughness(layout: Layout, samples: Array, noise: Array) -> Array:
    edges = [piece.first for piece in layout.pieces] + [len(samples)]
    level = np.square(local_level(layout.time, samples, edges))
    limit = ROUGH * float(np.linalg.norm(noise)) + UNEVEN * EPSILON * np.max(np.abs(samples))
    return np.maximum(level - limit**2, 0.0) / samples.shape[1]


def _from_there_on(found: Fit, time: Array, kinks: Sequence[Kink], known: Sequence[Break]) -> None:
    """
    Tell velocities at the instant of a jump that was found as those after it.

    Who gives an instant tells samples of before; a contact strikes within the step up to a sample.
    """
    given = {int(np.searchsorted(time, b.instant - NEAR * (time[1] - time[0]))) for b in known}
    for kink in kinks:
        for sample in {kink.first, kink.last} - given:
            for derivatives in (found.own, found.judge):
                derivatives[BEFORE][sample] = derivatives[1][sample]


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
    lost += samples.shape[1] * float(np.mean(np.square(missed(found, layout.time, noise)[2])))
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


def missed(found: Fit, time: Array, noise: Array) -> list[Array]:
    """
    What a spline that smooths misses in value, first and second derivative: (n,) of each column.

        m_k = m_0 w^k,   m_0^2 = mean of |y - s|^2 / d beyond that of noise,   w = pi n / T
        T : time over which the mean is taken, from that of n = WINDOW coefficients down to
            SHORTEST samples; the largest counts. What is not followed changes as fast at least
    """
    missing = [np.zeros(len(time)) for _ in range(3)]
    if not found.smooths:
        return missing
    columns = found.residual.shape[1]
    by_noise = np.mean(np.square(noise)) * np.clip(1.0 - found.response[0], 0.0, 1.0)
    square = _less_outliers(np.mean(np.square(found.residual), axis=1))
    spans, share = spans_of(time), found.share
    while True:
        counted = np.maximum(WINDOW / np.maximum(share, TINY), 3.0)
        limit = 1.0 + UNLIKE_NOISE * np.sqrt(2.0 / (columns * counted))
        excess = _averaged(square[:, None], share)[:, 0] - limit * by_noise
        value = np.sqrt(np.maximum(excess, 0.0))
        for order, each in enumerate(missing):
            np.maximum(each, value * (np.pi * share / spans) ** order, out=each)
        if np.min(share) >= WINDOW / SHORTEST:
            return missing
        share = np.minimum(2.0 * np.maximum(share, TINY**0.25), WINDOW / SHORTEST)


def _less_outliers(square: Array) -> Array:
    """Squares (n,) of which none is larger than both beside it: one bad sample is no motion."""
    padded = np.pad(square, 1, mode='edge')
    return np.minimum(square, np.maximum(padded[:-2], padded[2:]))


def steep(followed: Followed, time: Array) -> list[tuple[float, float]]:
    """Stretches, from and to, in which the samples change faster than they tell."""
    found = followed.fit
    by_noise = found.response[1] * np.sum(np.square(followed.noise))
    marked = (found.rough > 0.0) | (
        np.square(missed(found, time, followed.noise)[1]) > STEEP**2 * by_noise
    )
    for kink in followed.kinks:
        if kink.apart or kink.transition:
            marked[kink.first : kink.last + 1] = True
    at = np.flatnonzero(marked)
    if not len(at):
        return []
    runs = np.split(at, np.flatnonzero(np.diff(at) > MERGED) + 1)
    return [(float(time[run[0]]), float(time[run[-1]])) for run in runs]


def _by_roughness(found: Fit, order: int) -> Array:
    """
    What jumps that are not known, and outliers, do to a derivative beyond the judge: (n,).

    The judge rings as the spline does: of a jump of the velocity their distance is a half to a
    third of the error, of an outlier a fourteenth. So the samples are taken for as noisy there as
    they are rough, but for no more than ALIKE such distances.
    """
    distance = np.sqrt(np.mean(np.square(found.own[order] - found.judge[order]), axis=1))
    padded = np.pad(distance, NEIGHBOURS)
    around = np.max(np.lib.stride_tricks.sliding_window_view(padded, 2 * NEIGHBOURS + 1), axis=1)
    return np.minimum(np.sqrt(found.rough * found.response[order]), ALIKE * around)


def unsure(followed: Followed, time: Array, tick: float = 0.0) -> list[Array]:
    """
    How far value, first and second derivative may be wrong beside noise and judge: (n,) each.

    What the spline misses; in a transition all that changes there; beside a jump whose instant is
    blurred the chance to be on its other side; and where forces act in ticks, what a jump of the
    second derivative makes of its instant in one.
    """
    strays = [each.copy() for each in missed(followed.fit, time, followed.noise)]
    for order in range(len(strays)):
        strays[order] += _by_roughness(followed.fit, order)
    for kink in followed.kinks:
        lasts = float(time[kink.last] - time[kink.first])
        if kink.transition or kink.apart:
            inside = slice(kink.first + (not kink.apart), kink.last + kink.apart)
            strays[1][inside] += kink.speed + 0.5 * kink.change * lasts
            strays[2][inside] += kink.change + 2.0 * kink.speed / lasts
            continue
        instant, continuity = kink.breaks[0].instant, kink.breaks[0].continuity
        for sample in (kink.first, kink.last):
            away = abs(float(time[sample]) - instant)
            if kink.blur > NEAR * lasts:
                chance = np.exp(-0.5 * (away / kink.blur) ** 2) * 0.5
                strays[1 + continuity][sample] += np.sqrt(chance) * (
                    kink.change if continuity else kink.speed
                )
            if continuity:
                strays[1][sample] += kink.change * kink.blur
            if away < tick:
                strays[1][sample] += ROUNDED_TICK * (tick - away) * kink.change
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
