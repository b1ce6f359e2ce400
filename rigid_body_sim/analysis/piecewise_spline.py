# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Derivatives of a sampled motion by least squares on splines that are cut where the motion is known
to be less smooth.

    min sum_i |y_i - s(t_i)|^2   over splines s in pieces of degree d, knots inside each piece
    at a break of continuity c   s, s', ..., s^(c) have no jump: c = 1 where a force jumps,
                                 c = 0 where an impulse strikes
                                 c = -1 where a body was put elsewhere: nothing is shared
    at the ends                  s^(j) = given value, or s^(j)(end) = s^(j)(start), or nothing

The samples, the breaks and the number of coefficients alone decide the linear map from samples to
derivatives. With as many coefficients as samples the spline goes through them; with fewer it
smooths. Knots are averages of the samples' times, or of as many times spread over them as there
are coefficients (de Boor's aptknt: not-a-knot ends where samples are even). They are spread evenly
over the time, but no denser than the samples (`evenly`), so that one bandwidth holds wherever the
samples bear it: half the free coefficients per second [Hz]; faster motion is not followed.

A piece may have few samples or none: what it lacks comes from its neighbours through the
continuity, and its degree is as high as that allows (`shares`). A break that leaves its piece less
than a parabola is given up, and told.

At a break derivatives are those from there on; the first one is also told as it was up to there.

Source: de Boor, A Practical Guide to Splines, chapters XIII and XIV; least squares with equality
constraints: Bjoerck, Numerical Methods for Least Squares Problems, section 5.1; with the residuals
among the unknowns, and refined so: section 2.5 (`_Equations`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.interpolate import BSpline
from scipy.sparse.linalg import splu

Array = NDArray[np.float64]
Matrix = Any  # sparse, of scipy, whose stubs know too little of it

DEGREE = 5  # two derivatives keep order four; a higher one rings more on noise
JUDGE = 7  # degree of the spline that tells the error
FEWEST = 3  # coefficients of a piece: a parabola, an acceleration that does not change
SHARED = 2  # derivatives that short pieces can have in common: more than a parabola's are none
LONG = JUDGE + 1  # samples from which a piece needs nothing of its neighbours
ORDERS = 3  # value, first and second derivative
BEFORE = 3  # behind them: the first derivative up to a break
NEAR = 1e-6  # [sample spacing] a break this near to a sample, or to another, is at it
APART = 4  # samples between breaks of rates: nearer ones do more harm than good
CROWD, CROWDED = 6, 2  # jumps of forces in a row, with fewer samples for each, are none
REFINEMENTS = 2  # of the solution, at least
MOST_REFINEMENTS = 12  # where samples come close together
REFINED = 1e-13  # [-] of the coefficients: a last change that needs no other
MANY = 0.5  # [-] of the samples: more coefficients are found with the residuals
WEIGHT = 1e-2  # of the residuals there; from 1e-6 to 1e-1 it changes little


class Undetermined(ArithmeticError):
    """The samples do not determine the spline."""


@dataclass(frozen=True, order=True)
class Break:
    """
    An instant, in the unit of the samples' times, at which a motion is less smooth.

    continuity : how many derivatives of the position do not jump: 0 an impulse, 1 a force,
                 2 the rate of a force; -1: the position itself jumps
    """

    instant: float
    continuity: int = 1


@dataclass(frozen=True)
class End:
    """
    A condition at an end: derivative `order` is `value` (d,); `side` 0 is the first sample, -1 the
    last. Where `value` is None it is the same at both ends (`side` says nothing).
    """

    order: int
    value: Array | None
    side: int = 0


@dataclass(frozen=True, eq=False)
class Piece:
    """
    What lies between two breaks.

    first, end    : of its samples
    begin, finish : instants
    cap           : coefficients that samples and neighbours allow
    extra         : coefficients beside those for its samples, at its begin and its finish: for
                    end conditions, and of a long piece for the smoothness that it shares
    """

    first: int
    end: int
    begin: float
    finish: float
    cap: int
    extra: tuple[int, int] = (0, 0)

    @property
    def samples(self) -> int:
        """How many samples lie in it."""
        return self.end - self.first


@dataclass(frozen=True, eq=False)
class Layout:
    """
    Samples cut into pieces.

    breaks  : between the pieces
    dropped : breaks that were given up: too few samples tell of them
    """

    time: Array
    pieces: tuple[Piece, ...]
    breaks: tuple[Break, ...]
    dropped: tuple[Break, ...]
    ends: tuple[End, ...]


def cut(time: Array, breaks: Sequence[Break] = (), ends: Sequence[End] = ()) -> Layout:
    """Cut samples (n,), ascending, at the breaks inside them."""
    kept, dropped = _told_apart(time, _merged(time, breaks))
    extra = _extra(ends)
    while True:
        edges = [0, *(int(np.searchsorted(time, b.instant)) for b in kept), len(time)]
        sampled = [bool(time[i] == b.instant) for i, b in zip(edges[1:], kept)]
        caps = shares(np.diff(edges).tolist(), [b.continuity for b in kept], sampled, extra)
        poor = [i for i, cap in enumerate(caps) if cap < FEWEST]
        if not poor or not kept:
            break
        dropped.append(kept.pop(_nearest_break(poor[0], edges)))
    added = _added(np.diff(edges).tolist(), kept, extra)
    instants = [float(time[0]), *(b.instant for b in kept), float(time[-1])]
    pieces = tuple(
        Piece(
            edges[i],
            edges[i + 1],
            instants[i],
            instants[i + 1],
            caps[i],
            added[i],
        )
        for i in range(len(kept) + 1)
    )
    return Layout(time, pieces, tuple(kept), tuple(sorted(dropped)), tuple(ends))


def _merged(time: Array, breaks: Sequence[Break]) -> list[Break]:
    """Breaks between the first sample and the last, one at each instant, at samples if near."""
    merged: dict[float, int] = {}
    last = -np.inf
    for b in sorted(breaks):
        if not time[0] < b.instant < time[-1] or b.continuity >= DEGREE:
            continue
        i = int(np.clip(np.searchsorted(time, b.instant), 1, len(time) - 1))
        spacing = float(time[i] - time[i - 1])
        near = (float(time[i - 1]), float(time[i]), last)
        instant = min(near, key=lambda t: abs(t - b.instant))
        if abs(instant - b.instant) > NEAR * spacing:
            instant = b.instant
        last = instant
        merged[instant] = min(b.continuity, merged.get(instant, DEGREE))
    inside = [t for t in sorted(merged) if time[0] < t < time[-1]]
    return [Break(instant, merged[instant]) for instant in inside]


def _told_apart(time: Array, breaks: list[Break]) -> tuple[list[Break], list[Break]]:
    """
    Leave out breaks of rates that lie near others, and of forces where they come in a crowd: as
    often as the samples, they are no jumps to a spline. What is left out of the second kind is
    told.
    """
    places = np.searchsorted(time, [b.instant for b in breaks])
    strong = [i for i, b in enumerate(breaks) if b.continuity <= 1]
    crowd = {
        strong[k]
        for k in range(len(strong))
        if (hood := strong[max(0, k - CROWD // 2) : k + CROWD // 2 + 1])
        and len(hood) > CROWD // 2 + 1
        and places[hood[-1]] - places[hood[0]] < CROWDED * (len(hood) - 1)
    }
    taken = [places[i] for i in strong if i not in crowd]
    kept, last = [], -APART
    for i, b in enumerate(breaks):
        near = np.searchsorted(taken, places[i])
        around = [abs(int(t) - int(places[i])) for t in taken[max(0, near - 1) : near + 1]]
        if b.continuity <= 1:
            if i not in crowd:
                kept.append(b)
        elif min([*around, int(places[i]) - last]) >= APART:
            kept.append(b)
            last = int(places[i])
    return kept, [breaks[i] for i in sorted(crowd)]


def with_fewer(layout: Layout) -> list[Break]:
    """Breaks of a layout less those that it can best do without: of rates, else the densest."""
    strong = [b for b in layout.breaks if b.continuity <= 1]
    if len(strong) < len(layout.breaks):
        return strong
    sizes = [piece.samples for piece in layout.pieces]
    room = [min(pair) for pair in pairwise(sizes)]
    most = len(strong) - max(1, len(strong) // 4)
    worth = [(b.continuity < 0, n) for b, n in zip(strong, room)]
    kept = sorted(range(len(strong)), key=lambda i: worth[i], reverse=True)[:most]
    return [strong[i] for i in sorted(kept)]


def _extra(ends: Sequence[End]) -> tuple[int, int]:
    """Conditions at the start and at the end; what links both counts half for each."""
    linked = sum(end.value is None for end in ends)
    first = sum(end.value is not None and end.side == 0 for end in ends)
    return first + (linked + 1) // 2, len(ends) - first - (linked + 1) // 2


def shares(
    samples: list[int], continuity: list[int], sampled: list[bool], extra: tuple[int, int]
) -> list[int]:
    """
    How many coefficients each piece may have so that all of them are determined.

    A piece has its samples, and of the equations at a break a short one beside a long one has all,
    two short ones half each. A sample at the break belongs to the piece after it; by the equation
    of the values it tells as much to the piece before it, which so has this one. Who then has less
    than a parabola takes what it lacks from neighbours that have more.

        continuity, sampled : of each break, and whether a sample lies there
    """
    doubled = [2 * n for n in samples]
    for i, (c, at_sample) in enumerate(zip(continuity, sampled)):
        left, right = samples[i] < LONG, samples[i + 1] < LONG
        smooth = min(c, SHARED)
        shared = 2 * (smooth if at_sample else smooth + 1)
        before = shared if left and not right else 0 if right and not left else shared // 2
        doubled[i] += before + (2 if at_sample and left else 0)
        doubled[i + 1] += shared - before
    doubled[0] += 2 * extra[0]
    doubled[-1] += 2 * extra[1]
    for i, has in enumerate(doubled):
        for giver in (i - 1, i + 1):
            lack = 2 * FEWEST - doubled[i]
            shares_some = 0 <= giver < len(doubled) and continuity[min(i, giver)] >= 0
            if has < 2 * FEWEST and lack > 0 and shares_some:
                given = max(0, min(lack, doubled[giver] - 2 * FEWEST))
                doubled[giver] -= given
                doubled[i] += given
    return [has // 2 for has in doubled]


def _added(
    samples: list[int], breaks: list[Break], extra: tuple[int, int]
) -> list[tuple[int, int]]:
    """
    Coefficients of each piece beside those for its samples.

    Two long pieces whose accelerations do not jump where they meet have more equations there than
    a spline without a break: for so many more coefficients they are worth.
    """
    added = [[0, 0] for _ in samples]
    for i, b in enumerate(breaks):
        if min(samples[i], samples[i + 1]) >= LONG and b.continuity > 1:
            more = b.continuity - 1
            added[i][1] += more // 2
            added[i + 1][0] += more - more // 2
    added[0][0] += extra[0]
    added[-1][1] += extra[1]
    return [(first, last) for first, last in added]


def _nearest_break(piece: int, edges: list[int]) -> int:
    """The break between a piece and its neighbour with fewer samples."""
    sizes = np.diff(edges)
    if piece == 0:
        return 0
    if piece == len(sizes) - 1 or sizes[piece - 1] <= sizes[piece + 1]:
        return piece - 1
    return piece


@dataclass(frozen=True)
class Order:
    """
    Degree and coefficients of the spline of one piece.

    judged : whether the judge of this piece is another spline
    """

    degree: int
    coefficients: int
    judged: bool = True


def evenly(spans: Array, total: float) -> Array:
    """
    Spread coefficients evenly over the time, at most one to each span.

        w_i = min(1, c h_i),   sum_i w_i = total
        spans   : (n,) h_i > 0, what of the time is each sample's
        total   : coefficients; as many as spans or more: the same to each
        returns : (n,) w_i

    Between two neighbours of knots that are one coefficient apart lies at least one sample.
    """
    count = len(spans)
    if total >= count:
        return np.full(count, total / max(1, count))
    order = np.sort(spans)
    thinned = np.arange(1, count + 1)  # how many of the shortest have less than one
    rates = (total - (count - thinned)) / np.cumsum(order)
    longer = np.append(order[1:], np.inf)
    holds = np.flatnonzero((rates > 0.0) & (rates * longer >= 1.0))
    return np.minimum(1.0, rates[holds[0]] * spans)


def spans_of(time: Array) -> Array:
    """Time that is each sample's: half way to its neighbours, at the ends as if mirrored."""
    gaps = np.diff(time)
    return 0.5 * (np.append(gaps[0], gaps) + np.append(gaps, gaps[-1]))


def orders(
    piece: Piece, wanted: float, fewest: int = FEWEST, *, through: bool = False
) -> tuple[Order, Order]:
    """
    Choose the spline of a piece and the one that judges it, of a higher degree: by two where it
    goes through the samples and these allow it.

        wanted  : coefficients for its samples, at most one for each
        fewest  : coefficients of a piece, where its samples allow it
        through : whether it goes through the samples
    """
    n, extra = piece.samples, sum(piece.extra)
    cap = piece.cap if n < LONG else min(piece.cap, n + extra)
    least = max(FEWEST, extra)
    own = max(least, min(max(round(wanted) + extra, DEGREE + 1 if through else fewest), cap))
    degree = min(DEGREE, own - 1)
    more = 2 if through else 1  # the more, the more noise in the judge
    above = min(own + more, cap)
    if above == own and own <= JUDGE and own > least:  # one polynomial has all: the judge
        own -= 1
        degree = min(DEGREE, own - 1)
    judge = Order(min(degree + more, above - 1), above)
    return Order(degree, own, judge.degree > degree), judge


class Spline:
    """
    The linear map from samples to value and derivatives of the least-squares spline.

    free : coefficients less the equations of continuity and of the ends
    """

    def __init__(self, layout: Layout, chosen: Sequence[Order]) -> None:
        self._layout = layout
        self._sizes = [order.coefficients for order in chosen]
        self._knots = [_knots(layout.time, *pair) for pair in zip(layout.pieces, chosen)]
        self._degrees = [order.degree for order in chosen]
        self._starts = np.concatenate(([0], np.cumsum(self._sizes)))
        self._at_samples = [self._rows(order) for order in range(ORDERS)]
        self._conditions = self._tied_rows()
        self.free = int(self._starts[-1]) - self._conditions.shape[0]
        self._before = self._rates_before()
        self._equations = _Equations(
            self._at_samples[0], self._conditions, steep=self.free > MANY * len(layout.time)
        )

    def derivatives(self, samples: Array, *, tied: bool = True) -> list[Array]:
        """
        Value, first and second derivative at the samples, and the first one up to them.

            samples : (n, d)
            tied    : whether the end conditions have their values; else zero, as for what is added
                      to samples
            returns : four arrays (n, d); the last two differ where an impulse strikes at a sample
        """
        wanted = np.zeros((self._conditions.shape[0], samples.shape[1]))
        if tied:
            self._give(wanted)
        coefficients = self._equations.solve(samples, wanted)
        if not np.all(np.isfinite(coefficients)):
            raise Undetermined('the samples do not determine the spline')
        results = [rows @ coefficients for rows in self._at_samples]
        results.append(results[1].copy())
        for sample, row in self._before:
            results[BEFORE][sample] = row @ coefficients
        return results

    def _rows(self, order: int) -> Matrix:
        """Map coefficients to derivative `order` at the samples, that from there on."""
        blocks = [
            _design(self._layout.time[p.first : p.end], knots, degree, order)
            for p, knots, degree in zip(self._layout.pieces, self._knots, self._degrees)
        ]
        return sparse.block_diag(blocks, format='csr')

    def _row_at(self, piece: int, instant: float, order: int) -> Matrix:
        rows: Matrix = _design(
            np.array([instant]), self._knots[piece], self._degrees[piece], order
        )
        row = rows.tocoo()
        columns = row.col + self._starts[piece]
        return sparse.csr_array((row.data, (row.row, columns)), shape=(1, int(self._starts[-1])))

    def _tied_rows(self) -> Matrix:
        """Map coefficients to what is tied: jumps at breaks, and derivatives at the ends."""
        rows, layout = [], self._layout
        for i, b in enumerate(layout.breaks):
            highest = min(b.continuity, max(self._degrees[i], self._degrees[i + 1]))
            for order in range(highest + 1):  # beyond, all of them are zero
                step = self._step(i, i + 1) ** order
                difference = self._row_at(i + 1, b.instant, order) - self._row_at(
                    i, b.instant, order
                )
                rows.append(step * difference)
        last = len(layout.pieces) - 1
        for end in layout.ends:
            step = self._step(0, last) ** end.order
            first = self._row_at(0, layout.pieces[0].begin, end.order)
            final = self._row_at(last, layout.pieces[-1].finish, end.order)
            if end.value is None:
                rows.append(step * (final - first))
            else:
                rows.append(step * (first if end.side == 0 else final))
        if not rows:
            return sparse.csr_array((0, int(self._starts[-1])))
        return sparse.vstack(rows, format='csr')

    def _give(self, wanted: Array) -> None:
        """Write the values of the end conditions."""
        ends, last = self._layout.ends, len(self._layout.pieces) - 1
        for row, end in zip(wanted[len(wanted) - len(ends) :], ends):
            if end.value is not None:
                row[:] = self._step(0, last) ** end.order * end.value

    def _step(self, *pieces: int) -> float:
        """Distance of knots near a break: makes the equations of all orders alike."""
        return min(
            (self._layout.pieces[i].finish - self._layout.pieces[i].begin) / self._sizes[i]
            for i in pieces
        )

    def _rates_before(self) -> list[tuple[int, Matrix]]:
        """First derivatives up to impulses that strike at samples."""
        found = []
        for i, b in enumerate(self._layout.breaks):
            sample = self._layout.pieces[i + 1].first
            if b.continuity == 0 and self._layout.time[sample] == b.instant:
                found.append((sample, self._row_at(i, b.instant, 1)))
        return found


class _Equations:
    """
    Least squares with conditions: residuals r, coefficients c and forces f with

        w r + A c = y,   A^T r + C^T f = 0,   C c = g

    Factors of A^T A (r eliminated, w = 1) square the condition of A. That is nothing where a
    spline smooths; where it goes through samples of which two come close together, no digit is
    left. So there r is an unknown (steep), which takes 50 times as long where samples are many
    more than coefficients.

    value, tied : A, C
    """

    def __init__(self, value: Matrix, tied: Matrix, *, steep: bool) -> None:
        self._value, self._tied, self._steep = value, tied, steep
        self._weight = WEIGHT if steep else 1.0
        if steep:
            residuals = self._weight * sparse.eye_array(value.shape[0])
            blocks = [[residuals, value, None], [value.T, None, tied.T], [None, tied, None]]
        else:
            blocks = [[value.T @ value + tied.T @ tied, tied.T], [tied, None]]
        try:
            self._factors = splu(sparse.bmat(blocks, format='csc'))
        except RuntimeError as error:
            raise Undetermined('the samples do not determine the spline') from error

    def solve(self, samples: Array, wanted: Array) -> Array:
        """Return the coefficients for y and g, refined until they settle."""
        value, tied = self._value, self._tied
        residuals, last = np.zeros_like(samples), np.inf
        coefficients = np.zeros((value.shape[1], samples.shape[1]))
        forces = np.zeros_like(wanted)
        for done in range(1 + MOST_REFINEMENTS):
            more, change, pull = self._solve_once(
                samples - self._weight * residuals - value @ coefficients,
                -(value.T @ residuals + tied.T @ forces),
                wanted - tied @ coefficients,
            )
            residuals, coefficients = residuals + more, coefficients + change
            forces = forces + pull
            moved = float(np.max(np.abs(change)))
            settled = moved <= REFINED * float(np.max(np.abs(coefficients)))
            if done >= REFINEMENTS and (settled or not moved < 0.5 * last):
                break
            last = moved
        return coefficients

    def _solve_once(self, first: Array, second: Array, third: Array) -> tuple[Array, ...]:
        """Solve the three equations with such right-hand sides, to what the factors bear."""
        count, size = self._value.shape
        if self._steep:
            found = self._factors.solve(np.concatenate((first, second, third)))
            return found[:count], found[count : count + size], found[count + size :]
        upper = self._value.T @ first - second + self._tied.T @ third
        found = self._factors.solve(np.concatenate((upper, third)))
        coefficients, forces = found[:size], -found[size:]
        return first - self._value @ coefficients, coefficients, forces


def _knots(time: Array, piece: Piece, order: Order) -> Array:
    """Knots of one piece, ends repeated."""
    degree, inner = order.degree, order.coefficients - order.degree - 1
    ends = np.repeat(piece.begin, degree + 1), np.repeat(piece.finish, degree + 1)
    if inner == 0:
        return np.concatenate(ends)
    own = time[piece.first : piece.end]
    sites = np.concatenate(
        (np.repeat(own[0], piece.extra[0]), own, np.repeat(own[-1], piece.extra[1]))
    )
    if order.coefficients != len(sites):
        sites = _spread(sites, piece.extra, order.coefficients)
    sums = np.cumsum(np.concatenate(([0.0], sites - sites[0])))
    middle = sites[0] + (sums[1 + degree : -1] - sums[1 : -degree - 1]) / degree
    return np.concatenate((ends[0], middle, ends[1]))


def _spread(sites: Array, extra: tuple[int, int], count: int) -> Array:
    """Spread so many times over those of samples, whose first and last are repeated."""
    gaps = np.diff(sites)
    own = gaps[extra[0] : len(gaps) - extra[1]]
    if len(own):  # a repeated time counts as one more sample
        gaps = np.pad(own, extra, mode='edge')
    else:
        gaps = np.ones_like(gaps)
    reached = np.concatenate(([0.0], np.cumsum(evenly(gaps, count - 1.0))))
    return np.interp(np.linspace(0.0, reached[-1], count), reached, sites)


def _design(x: Array, knots: Array, degree: int, order: int) -> Matrix:
    """Map the coefficients of a spline to its derivative at x."""
    size = len(knots) - degree - 1
    if order > degree:
        return sparse.csr_array((len(x), size))
    lower: Matrix = sparse.eye_array(size, format='csr')
    for _ in range(order):
        size, width = size - 1, knots[degree + 1 : -1] - knots[1 : -degree - 1]
        scale = sparse.diags_array(degree / width)
        lower = (
            scale
            @ (sparse.eye_array(size, size + 1, k=1) - sparse.eye_array(size, size + 1))
            @ lower
        )
        knots, degree = knots[1:-1], degree - 1
    if not len(x):
        return sparse.csr_array((0, lower.shape[1]))
    return sparse.csr_array(BSpline.design_matrix(x, knots, degree)) @ lower
