# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The work of all that has no potential, along the motion that a run makes: its power, integrated.

    W = sum over the smooth stretches of  int P dt,    P : `forces.power`, at the states of the run

A stretch lasts from one jump of the power to the next: another command, an impulse, the begin or
end of a force. Within it the power at the ticks is enough, by the trapezoidal rule with the
corrections of Euler and Maclaurin at both ends,

    int P dt = h (P_M / 2 + P_M+1 + … + P_N / 2) - h [C(N) - C(M)]
    C = h D P / 12 - h^3 D^3 P / 720 + h^5 D^5 P / 30240,    D : derivative with time

The derivatives are those of the polynomial through the power in 4 or 8 pieces of a tick, into
which a tick at each end is divided for the purpose: the state is copied, advanced over the pieces,
and put back, so that no bit of the run changes. The first tick of a stretch is integrated over its
pieces, by the rule of Newton and Cotes; so are those that follow, while the motion is too fast for
its ticks (the higher the order of the method, the sooner it is), in up to 64 times as many pieces
where a method of high order passes what is nearly singular within a tick. A method that divides
its ticks into substeps is looked at in up to eight places of a tick.

The error of the quadrature is estimated with it: from what one piece less would have given, and
from what the power holds that changes sign from tick to tick. Where a step does not resolve what
decays or swings in it, no quadrature can know the work; then this error is as large as the work.

Where bodies meet, velocities jump inside ticks: there it is the plain trapezoidal rule. Of a power
that jumps by J somewhere in a tick it knows the integral to h |J| / 2, and of one that bends to
h |P_k+1 - 2 P_k + P_k-1| / 12. Both are within

    h / 4 sum over k of |P_k+1 - 2 P_k + P_k-1|,    P_M-1 = P_M,  P_N+1 = P_N

as a jump inside a tick shows at both of its ends.

Source: Hildebrand, Introduction to Numerical Analysis, sections 5.8 and 3.10.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache, wraps
from itertools import pairwise
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import argument
from rigid_body_sim.physics.forces.power import SUMS, Powers
from rigid_body_sim.physics.integration.integrator import Integrator

Array = NDArray[np.float64]

ROWS = 512  # looks at the power between two additions: none of them costs numpy more than a call
EULER_MACLAURIN = {1: 1 / 12, 3: -1 / 720, 5: 1 / 30240}  # by derivative
GREGORY = (1 / 12, 1 / 24, 19 / 720, 3 / 160)  # by backward difference
# [-] of the power, by the largest order of a method: what one piece less may give otherwise at
# the ends of the sum over ticks. For order two some 0.7 rad a tick; the defect of a method of high
# order is smaller, and so must be what the quadrature leaves
TOO_FAST = {2.0: 1e-3, 4.0: 1e-5, math.inf: 1e-11}
TOO_FEW = (
    1e-9  # [-] of the power: the same of the integral over a tick, of methods above order four
)
MORE_PARTS, MOST_PARTS = 4, 64  # of a tick, each in pieces: where ends of springs meet
SNAP_DIGITS = 8  # [tick] so near to a boundary a kink is at it: wider than `schedule.SNAP`
ROUGH = 0.05  # [-] of the largest power: its second difference; 0.2 rad a tick
PLACES = 8  # looks into a tick of many substeps; more cost time, and find nothing new
LEFT = 0.1  # [-] of what the last extrapolation changed, for what is left
ALTERNATING = 12  # differences: they leave of the power what changes sign from tick to tick
ROUNDING = 1e-15  # [-] of kinetic and potential energy: of reading them, not of the run
QUARTER = 0.25  # [-] of the difference to ticks twice as long: what a kink leaves, nothing more

# sums of a meter, a row of one number for each of commands, drives and dissipation
CLOSED, CLOSED_ERROR, PIECES, PIECES_ERROR, SUM, HEAD, HEAD_ERROR, SWING, LARGEST = range(9)


class Motion(Protocol):
    """What is asked of a stepper that advances with one kernel."""

    integrator: Integrator
    translation: Array
    rotation: Array

    def steps(self, count: int, first: float, h: float) -> bool:
        """Make steps of the method of a length [s], the first beginning at first * h."""
        ...

    def snapshot(self) -> Any:
        """Copy all that moves."""
        ...

    def return_to(self, snapshot: Any) -> None:
        """Put back what `snapshot` gave."""
        ...


def _quiet(method: Callable[..., Any]) -> Callable[..., Any]:
    """Let a method print no warnings of numpy: a run about to diverge says so itself."""

    @wraps(method)
    def quietly(*arguments: Any, **options: Any) -> Any:
        with np.errstate(over='ignore', invalid='ignore'):
            return method(*arguments, **options)

    return quietly


class WorkMeter:
    """
    Adds up the work while a stepper advances.

    powers : of what acts
    smooth : whether velocities are: no bodies meet
    """

    def __init__(self, powers: Powers, integrator: Integrator, *, smooth: bool) -> None:
        self.powers = powers
        self._smooth = smooth
        self._rows = np.zeros((ROWS, SUMS))
        self._row_arguments = [argument(row) for row in self._rows]
        self._sums = np.zeros((9, SUMS))
        self._h = math.nan  # between two rows [s]
        self._bends_for = math.nan  # tick length [s]
        self._bends: set[float] = set()  # tick boundaries at which a derivative of a power jumps
        self._motion: Motion | None = None
        self._place = 0.0  # where the run stands [h]
        self._begin_stretch()
        self.take_method(integrator)

    def take_method(self, integrator: Integrator) -> None:
        """Go on with a method: choose pieces and places in a tick for it."""
        self.cut()
        self._integrator = integrator
        self._pieces = 4 if integrator.order <= 2 else 8
        self._looks_close = integrator.order > 2
        self._too_few = TOO_FEW if integrator.order > 4 else math.inf
        self._too_fast = next(x for most, x in TOO_FAST.items() if integrator.order <= most)
        self._substeps = integrator.substeps
        self._places = max(k for k in range(1, PLACES + 1) if self._substeps % k == 0)
        self._weights = _weights_of(self._pieces)
        self._local = np.zeros((self._pieces + 1, SUMS))
        self._largest = np.zeros(SUMS)  # of the power over the step that was divided last
        self._local_arguments = [argument(row) for row in self._local]

    def _begin_stretch(self) -> None:
        self._count = 0  # rows in use; none: the stretch has not begun
        self._first = -1  # first row of the sum over rows; -1: steps are divided into pieces
        self._gone = 0  # rows put away
        self._sums[PIECES:] = 0.0

    def mark(self) -> tuple[Any, ...]:
        """Copy all sums, for `return_to`."""
        numbers = (self._count, self._first, self._gone, self._h, self._place)
        return numbers, self._sums.copy(), self._rows[: self._count].copy()

    def return_to(self, mark: tuple[Any, ...]) -> None:
        """Forget what came after a mark."""
        numbers, sums, rows = mark
        self._count, self._first, self._gone, self._h, self._place = numbers
        self._sums[:] = sums
        self._rows[: len(rows)] = rows

    @_quiet
    def cut(self) -> None:
        """End the stretch: from here on the power is another, or the motion is."""
        if self._count:
            self._sums[:PIECES] += self._of_stretch()
            self._begin_stretch()

    def add_jump(self, place: int, before: float, after: float, *, size: float) -> None:
        """
        Add work that was done at once, after a `cut`: that of an impulse.

        before, after : energy before and behind it [J]
        size          : of the parts that both are sums of [J]: how wrong they may be goes with it
        """
        self._sums[CLOSED, place] += after - before
        self._sums[CLOSED_ERROR, place] += ROUNDING * size
        self.powers.was_commanded = True

    @property
    def looks_ahead(self) -> bool:
        """Whether `work` and `cut` go ahead from here for a bit, and come back."""
        return self._smooth and 0 <= self._first < self._count - 1

    @property
    def was_commanded(self) -> bool:
        """Whether a command acted so far."""
        return self.powers.was_commanded

    @_quiet
    def work(self) -> tuple[Array, Array]:
        """Work so far, and how wrong its quadrature may be, (SUMS,) and (SUMS,) [J]."""
        found = self._sums[:PIECES].copy()
        if self._count:
            found += self._of_stretch()
        return found[0], found[1]

    @_quiet
    def follow(
        self, motion: Motion, ticks: int, tick: float, h: float, *, to_the_end: bool
    ) -> bool:
        """
        Advance over ticks, the first of them number `tick`, looking at the power.

        to_the_end : whether the stretch is known to end behind them
        returns    : whether all went well; if not, go back to a mark
        """
        if motion.integrator is not self._integrator:
            self.take_method(motion.integrator)
        places, steps = self._places, self._substeps // self._places
        if h / places != self._h:
            self.cut()
            self._h = h / places
        self._motion, self._place = motion, places * tick
        for number in range(1, ticks + 1):
            if not self._count:
                self._look(self._place * self._h)
            bends = self._bends_at(tick + number, h)
            ends = bends or (to_the_end and number == ticks)
            for left in range(places - 1, -1, -1):
                if not self._step(motion, steps, h / self._substeps, last=ends and left == 0):
                    return False
            if bends:
                self.cut()
        return True

    def _step(self, motion: Motion, steps: int, h: float, *, last: bool) -> bool:
        """Advance to the next place, the last of the stretch or another; whether it went well."""
        if self._smooth and self._first >= 0 and (last or self._is_rough()):
            self._end_rows()
        if self._first < 0:
            self._add_pieces()
        if not motion.steps(steps, steps * self._place, h):
            return False
        self._place += 1
        self._look(self._place * self._h)
        return True

    def _is_rough(self) -> bool:
        """
        Whether the power changes too fast from place to place to go on without pieces.

        Asked for methods above order two only: the error of the others is larger.
        """
        row = self._count - 1
        if not self._looks_close or row < 2:
            return False
        rows, largest = self._rows, self._sums[LARGEST]
        np.maximum(largest, abs(rows[row]), out=largest)
        bend = abs(rows[row] - 2.0 * rows[row - 1] + rows[row - 2])
        return bool((bend > ROUGH * largest).any())

    def _bends_at(self, tick: float, h: float) -> bool:
        """Whether a derivative of a power jumps at a tick boundary."""
        if not len(self.powers.kinks):
            return False
        if h != self._bends_for:
            self._bends_for = h
            self._bends = set(np.round(self.powers.kinks / h, SNAP_DIGITS).tolist())
        return round(float(tick), SNAP_DIGITS) in self._bends

    def _look(self, time: float) -> None:
        """Take the power now."""
        if self._count == ROWS:
            self._put_away()
        assert self._motion is not None
        row = self._row_arguments[self._count]
        self.powers.measure(time, self._motion.translation, self._motion.rotation, row)
        self._count += 1
        if self._first < 0:
            self._begin_rows()

    def _begin_rows(self) -> None:
        """Do without pieces from here on, if the power is smooth enough."""
        row = self._count - 1
        if not self._smooth:
            self._first, self._sums[HEAD] = row, 0.5 * self._rows[row]
        elif row and not (self._is_too_fast(AT_END, self._too_fast) or self._is_rough()):
            self._first = row
            self._sums[HEAD] = 0.5 * self._rows[row] - self._found[AT_END]
            self._sums[HEAD_ERROR] = abs(self._found[AT_END + 1])

    def _end_rows(self) -> None:
        """Divide steps into pieces from here on."""
        self._sums[PIECES : PIECES_ERROR + 1] = self._of_stretch()
        self._first = -1
        self._sums[SUM:LARGEST] = 0.0

    def _divide(self, parts: int = 1) -> bool:
        """
        Look at the power in pieces of the coming step, part by part; then stand where it begins.
        """
        motion, n, h = self._motion, self._pieces, self._h
        assert motion is not None
        pieces = parts * n
        steps = -(-self._substeps // (self._places * pieces))
        before = motion.snapshot()
        self._local[0] = self._rows[self._count - 1]
        whole, found = np.zeros((2, SUMS)), np.zeros((6, SUMS))
        went_well = True
        for piece in range(pieces):
            begin = pieces * self._place + piece
            went_well = motion.steps(steps, steps * begin, h / (pieces * steps))
            if not went_well:
                break
            out = self._local_arguments[piece % n + 1]
            self.powers.measure((begin + 1) * h / pieces, motion.translation, motion.rotation, out)
            if piece % n == n - 1:
                found = self._weights @ self._local
                whole += (found[WHOLE] / parts, abs(found[WHOLE + 1]) / parts)
                self._largest = np.maximum(self._largest, abs(self._local).max(axis=0))
                self._local[0] = self._local[n]
        motion.return_to(before)
        if not (went_well and np.isfinite(found).all()):
            return False
        found[WHOLE : WHOLE + 2] = whole
        if parts > 1:  # the ends of the sum over rows know whole steps alone
            found[AT_BEGIN + 1] = found[AT_END + 1] = math.inf
        self._found = found
        return True

    def _add_pieces(self) -> None:
        """Integrate over the coming step in pieces, and in more where they are too few."""
        self._largest = np.zeros(SUMS)
        if self._divide():
            parts = 1
            while parts < MOST_PARTS and self._is_too_fast(WHOLE, self._too_few):
                parts *= MORE_PARTS
                if not self._divide(parts):
                    break
        else:
            self._local[:] = self._rows[self._count - 1]
            self._found = self._weights @ self._local
            self._found[WHOLE + 1] = self._local[0]
        self._sums[PIECES] += self._h * self._found[WHOLE]
        self._sums[PIECES_ERROR] += self._h * abs(self._found[WHOLE + 1])

    def _is_too_fast(self, what: int, tolerated: float) -> bool:
        """Whether one piece less would have given something else [of the power]."""
        return bool((abs(self._found[what + 1]) > tolerated * self._largest).any())

    def _from_behind(self) -> tuple[Array, Array]:
        """C here from the last rows alone (Gregory), where the run cannot go ahead, and error."""
        rows = self._rows[max(0, self._count - len(GREGORY) - 1) : self._count]
        terms = [
            weight * np.diff(rows, n=order, axis=0)[-1]
            for order, weight in zip(range(1, len(rows)), GREGORY)
        ]
        return np.sum(terms, axis=0), abs(terms[-1])

    def _put_away(self) -> None:
        """Add up the rows, but for those that the next differences need."""
        keep = self._count - (ALTERNATING + 1)
        if self._first >= 0:
            self._sums[SUM] += self._rows[self._first : keep].sum(axis=0)
            self._sums[SWING] += self._swings() if self._smooth else self._bent()
            self._first = 0
        self._gone += keep
        self._rows[: self._count - keep] = self._rows[keep : self._count]
        self._count -= keep

    def _swings(self) -> Array:
        """Add up the differences of the rows with signs in turn, but for those put away."""
        m = ALTERNATING
        begin = m + 1 if self._gone else m
        differences = np.diff(self._rows[begin - m : self._count], n=m, axis=0)
        signs = 1.0 - 2.0 * ((np.arange(len(differences)) + begin + self._gone) % 2)
        return signs @ differences / 2.0**m

    def _bent(self) -> Array:
        """Add up how far the power bends at the rows but the last, and but for those put away."""
        begin = ALTERNATING if self._gone else 0
        rows = self._rows[max(begin - 1, 0) : self._count]
        steps = np.diff(rows if begin else np.concatenate((rows[:1], rows)), axis=0)
        return abs(np.diff(steps, axis=0)).sum(axis=0)

    def _left_by_jumps(self) -> Array:
        """How wrong the sum over rows is at most where the power may jump between them [W]."""
        last = self._count - 1
        end = abs(self._rows[last] - self._rows[last - 1])
        return QUARTER * (self._sums[SWING] + self._bent() + end)

    def _of_stretch(self) -> Array:
        """Work of the stretch so far, and its error, (2, SUMS) [J]."""
        found = self._sums[PIECES:SUM].copy()
        last = self._count - 1
        if self._first < 0 or self._first == last:
            return found
        correction, error = np.zeros(SUMS), np.zeros(SUMS)
        if self._smooth:
            if self._divide():
                correction, error = self._found[AT_BEGIN], abs(self._found[AT_BEGIN + 1])
            else:
                correction, error = self._from_behind()
        sums = self._sums
        summed = sums[SUM] + self._rows[self._first : self._count].sum(axis=0)
        found[0] += self._h * (summed - sums[HEAD] - 0.5 * self._rows[last] - correction)
        if self._smooth:
            left = QUARTER * np.abs(sums[SWING] + self._swings())
        else:
            left = self._left_by_jumps()
        found[1] += self._h * (sums[HEAD_ERROR] + error + left)
        return found


# what is found of a step from the power at its pieces, each with its error, over its length
WHOLE, AT_BEGIN, AT_END = 0, 2, 4  # the integral; C at the begin and at the end


@cache
def _weights_of(pieces: int) -> Array:
    """Give the weights (6, pieces + 1) of the values at the pieces in what is found of a step."""
    weights = np.zeros((6, pieces + 1))
    weights[WHOLE], weights[WHOLE + 1] = _whole(pieces)
    for degree, sign in ((pieces, 1.0), (pieces - 1, -1.0)):
        nodes = np.arange(degree + 1)
        if degree == pieces:
            weights[AT_BEGIN] = _correction(nodes / pieces)
            weights[AT_END] = _correction(nodes / pieces - 1.0)
        weights[AT_BEGIN + 1, : degree + 1] += sign * _correction(nodes / pieces)
        weights[AT_END + 1, pieces - degree :] += sign * _correction((nodes - degree) / pieces)
    return weights


def _correction(nodes: Array) -> Array:
    """Give the weights in C, at 0, of values at nodes: by the polynomial through them."""
    coefficients = np.linalg.inv(np.vander(nodes, increasing=True))
    found = np.zeros(len(nodes))
    for m, weight in EULER_MACLAURIN.items():
        if m < len(nodes):
            found += weight * math.factorial(m) * coefficients[m]
    return found


def _whole(pieces: int) -> tuple[Array, Array]:
    """
    Give the weights of the integral over a length of 1, and of its error: Romberg's rule for four
    pieces, which is Boole's; for eight the rule of Newton and Cotes, right up to degree nine, and
    what it differs by from Romberg's.
    """
    romberg, error = _romberg(pieces)
    if pieces < 8:
        return romberg, error
    nodes = np.arange(pieces + 1) / pieces
    moments = 1.0 / np.arange(1.0, pieces + 2.0)
    cotes = np.linalg.solve(np.vander(nodes, increasing=True).T, moments)
    return cotes, cotes - romberg


def _romberg(pieces: int) -> tuple[Array, Array]:
    """Give the weights of Romberg's rule over a length of 1, and of its error."""
    row, stride = [], 1
    while stride <= pieces:
        part = np.zeros(pieces + 1)
        part[::stride] = stride / pieces
        part[[0, -1]] *= 0.5
        row.append(part)
        stride *= 2
    factor, before = 4.0, row[0]
    while len(row) > 1:
        before = row[0]
        row = [(factor * fine - coarse) / (factor - 1.0) for fine, coarse in pairwise(row)]
        factor *= 4.0
    return row[0], LEFT * (row[0] - before)
