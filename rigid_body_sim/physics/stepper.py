# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The arrays of a scene and the kernels that advance them: only what the scene needs, compiled when
it is first needed.

A scene in which nothing depends on the state (commands in world axes, uniform gravity) takes the
free kernel; forces between bodies, drag, or a command in body axes take the coupled one. Where a
force begins, ends or has a kink at an instant of its own, the ticks are cut there
(`forces.schedule`).

The state and the count of its ticks belong together, whatever breaks off the work between: before
anything of them changes, `undo` gets what they were, and it is emptied when both are new. An
exception in between (KeyboardInterrupt comes anywhere) leaves it full, and `put_back` returns to
it.
"""

from __future__ import annotations

import itertools
import math
from collections import deque
from collections.abc import Callable
from functools import partial
from operator import setitem
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import (
    COMPILED,
    argument,
    left_the_numbers,
    prepared,
)
from rigid_body_sim.physics.compile.side_by_side import SideBySide, threads
from rigid_body_sim.physics.diagnostics.accelerations import accelerations_now
from rigid_body_sim.physics.diagnostics.work_meter import WorkMeter
from rigid_body_sim.physics.errors import SimulationBusy
from rigid_body_sim.physics.forces.acting_elements import ActingElements
from rigid_body_sim.physics.forces.power import DRIVES, Powers
from rigid_body_sim.physics.forces.schedule import SNAP
from rigid_body_sim.physics.integration.integrator import Integrator
from rigid_body_sim.physics.integration.schemes.scipy_reference import too_many_evaluations
from rigid_body_sim.physics.integration.schemes.splitting import Splitting
from rigid_body_sim.physics.integration.schemes.state_space.no_rotation import for_points
from rigid_body_sim.physics.integration.status import DID_NOT_CONVERGE, TOO_MANY_EVALUATIONS
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.physics.state.blocks import (
    ANGULAR_MOMENTUM,
    FORCE,
    HELD_FORCE,
    HELD_TORQUE,
    LANES,
    MOMENTUM,
    ORIENTATION,
    POSITION,
    ROTATION,
    ROTATION_STATE,
    TORQUE,
    TRANSLATION,
    TRANSLATION_STATE,
    blocks,
    gather,
    keep_motion,
    rows,
    scatter,
)
from rigid_body_sim.physics.state.contacts import NO_CONTACTS, Contacts
from rigid_body_sim.physics.state.impacts import NO_IMPACTS, Impacts
from rigid_body_sim.physics.state.layout import Layout
from rigid_body_sim.physics.state.placement import PlacedRows

Array = NDArray[np.float64]

METHOD, WORKSPACE = 4, 5  # their places among the arguments of a kernel
# [body tick] of a call from which free bodies go on several threads: some 2 ms of one
WORTH_THREADS = 200_000
BRIEF = 1000  # free bodies in whose tick (20 us) no other thread of Python gets its turn
PARTS_OF_EACH = 2  # of a thread: more wait for each other less, and cost a call each
CHUNK = 1000  # [tick] between two copies of the state, to which a run returns that goes wrong
# [body tick] the same where bodies meet; more: an interrupt waits longer and costs more ticks
CHUNK_IN_CONTACT = 20_000


# what work on the state began from: tick, copies of the arrays of `Stepper._state` (None:
# `_moving_rows` have them), what the contact noted (None: there is none), what the caller wants
# back beside, the work done by then (None: nobody asked). A tuple: each step makes one, and what
# has names costs five times as much
Undo = tuple[int, tuple[Array, ...] | None, Any, Any, Any]
# length of a tick [s], steps in it, their length [s], what copies the motion, and what makes them
OneTick = tuple[float, int, float, Callable[[], Any], Callable[[int, float, float], Any]]


class Stepper:
    """
    State and kernels of one run.

    tick                  : [tick] the count of ticks that the state has
    undo                  : what to return to if the work under way breaks off; None: nothing is
                            under way
    translation, rotation : blocks, see `state.blocks`
    cause                 : why the last advance stopped early; empty: a state left the finite
                            numbers
    work                  : the meter of the work of what has no potential; None: nobody asked
    is_timed              : whether a wrench depends on time itself; then ticks are passed to the
                            kernels as floats
    """

    def __init__(self, scene: Scene, layout: Layout, integrator: Integrator) -> None:
        self._layout = layout
        self._integrator = integrator
        self._substeps = integrator.substeps
        self.translation = layout.translation()
        self.rotation = layout.rotation()
        self._elements = ActingElements(scene, layout)
        self.is_timed = self._elements.is_timed
        self._method = self._blocks_of(self._method_rows())
        self.contact = _contact_world(scene, layout, integrator)
        self.tick = 0
        self.undo: Undo | None = None
        self._chunk = CHUNK
        if self.contact is not None:
            self._chunk = max(1, min(CHUNK, CHUNK_IN_CONTACT // max(1, layout.n_moving)))
        self._moving_rows = self._rows_that_move()
        self._keep: Callable[[], Any] | None = None  # copies them
        self._start = self._snapshot()
        self._scheme = integrator.scheme if layout.n_rigid else for_points(integrator.scheme)
        # methods that differ in how they turn bodies share one kernel where nothing turns
        self._kernel_name = integrator.name if self._scheme is integrator.scheme else 'points'
        size = self._scheme.workspace(blocks(layout.n_moving))
        self._workspace = np.zeros(size)
        self._workspace[: len(integrator.constants)] = integrator.constants
        self._scene = scene
        self._workspace_step: float | None = None
        self._turning = 0  # commands that turn with their bodies, in the arguments of the kernels
        self.cause = ''
        self._drives_before = 0.0  # [J] work of what moves bodies by contact, when that began
        self.work: WorkMeter | None = None
        self._workspaces: dict[float, Array] = {}  # the last few, by step
        self._free: Callable[..., Any] | None = None
        self._coupled: Callable[..., Any] | None = None
        self._call: Callable[[int, float, float], Any] = _nothing_yet
        self._called: tuple[Any, Any] = (None, None)  # kernel and arguments of `_call`
        self._one_tick: OneTick | None = None  # where nothing has to be looked at before a tick
        self._parts: list[Callable[..., Any]] = []  # the same for some blocks each, or none
        self._side_by_side = SideBySide()
        self._take_arguments()

    def _method_rows(self) -> Array:
        """
        Give the numbers per body that the integrator wants at hand, or what it remembers of the
        state.
        """
        remembers = self._integrator.remembers
        if remembers is None:
            return self._integrator.coefficients(self._layout.moments)
        return remembers(gather(self.rotation, ROTATION, ORIENTATION, 4, self._layout.n_rigid))

    @property
    def steps_taken(self) -> float:
        """Steps that the method chose itself so far; 0 where it does not choose them."""
        count = getattr(self._scheme, 'steps_taken', None)
        return count(self._workspace) if count is not None else 0.0

    def go_on_with(self, integrator: Integrator, told: partial[None]) -> None:
        """
        Take another integrator from here on; neither of the two may remember anything.

        told : is called with the change, so that an interrupt finds both or neither
        """
        self.cut_work()
        new = Stepper(self._scene, self._layout, integrator)
        arguments = (
            *self._arguments[:METHOD],
            *new._arguments[METHOD : WORKSPACE + 1],
            *self._arguments[WORKSPACE + 1 :],
        )
        mine = (
            '_integrator',
            '_substeps',
            '_method',
            '_scheme',
            '_kernel_name',
            '_workspace',
            '_workspaces',
        )
        taken = {
            name: new.__dict__[name] for name in (*mine, '_free', '_coupled', '_workspace_step')
        }
        change = partial(self.__dict__.update, taken, _arguments=arguments, _one_tick=None)
        # one call of C: no interrupt comes between
        deque(map(partial.__call__, (change, told)), maxlen=0)

    @property
    def _state(self) -> tuple[Array, ...]:
        """All arrays of which the next tick makes its own."""
        if self._integrator.remembers is None:
            return (self.translation, self.rotation)
        return (self.translation, self.rotation, self._method)

    def _snapshot(self) -> tuple[tuple[Array, ...], Any]:
        """Copy the motion, and what there is of contact."""
        motion = (self.translation.copy(), self.rotation.copy())
        if self._integrator.remembers is not None:
            motion = (*motion, self._method.copy())
        return motion, None if self.contact is None else self.contact.memory.snapshot()

    def _return_to(self, snapshot: tuple[tuple[Array, ...] | None, Any]) -> None:
        """Return to what `_snapshot` gave; no motion: to the one in the rows that were kept."""
        motion, of_contact = snapshot
        if motion is None:
            for kept, now in self._moving_rows or ():
                now[...] = kept
        else:
            for array, values in zip(self._state, motion, strict=False):
                array[:] = values
        if of_contact is not None:
            self.contact.memory.return_to(of_contact)

    def begin(self, more: Any = None) -> Undo:
        """Note what to return to; from here to `end` the state is nobody's."""
        mark = None if self.work is None else self.work.mark()
        motion, of_contact = self._snapshot()
        self.undo = undo = (self.tick, motion, of_contact, more, mark)
        return undo

    def _begin_ticks(self) -> Undo:
        """
        Do what `begin` does, into arrays that the next ticks use again: of free bodies the rows
        that a tick changes and no others.
        """
        if self._keep is None:
            if self._moving_rows is None:
                return self.begin()
            sizes = np.array([kept.shape[1] for kept, _ in self._moving_rows], dtype=np.int64)
            kept = (argument(kept.reshape(-1)) for kept, _ in self._moving_rows)
            last = (*self._arguments[:METHOD], argument(sizes), *kept)
            self._keep = prepared(keep_motion, (), last, brief=True)
        self._keep()
        of_contact = None if self.contact is None else self.contact.memory.keep()
        self.undo = undo = (self.tick, None, of_contact, None, None)
        return undo

    def _rows_that_move(self) -> list[tuple[Array, Array]] | None:
        """
        Pair what a tick changes with a place for a copy; None where the integrator remembers more.
        """
        if self._integrator.remembers is not None:
            return None
        is_free = self.contact is None
        heads = (
            self.translation.reshape(-1, TRANSLATION)[:, : TRANSLATION_STATE if is_free else None],
            self.rotation.reshape(-1, ROTATION)[:, : ROTATION_STATE if is_free else None],
        )
        return [(np.array(head), head) for head in heads]

    def end(self, undo: Undo, ticks: int = 0) -> None:
        """Count the ticks that were done since `begin`; SimulationBusy if another began too."""
        if self.undo is not undo:
            raise SimulationBusy
        self.tick += ticks
        self.undo = None

    def put_back(self) -> None:
        """Return to what `begin` noted, if the work broke off; can itself be broken off."""
        self._side_by_side.rest()
        contact = self.contact
        if contact is not None:
            contact.ticks.rest()
        if self.undo is not None:
            self.tick, motion, of_contact, _more, work = self.undo
            self._return_to((motion, of_contact))
            if self.work is not None and work is not None:
                self.work.return_to(work)
            self.undo = None

    def measure_work(self) -> WorkMeter:
        """Begin to add up the work of what has no potential."""
        powers = Powers(self._elements)
        powers.prepare(argument(self.translation), argument(self.rotation))
        self._drives_before = 0.0 if self.contact is None else self.contact.arrays.work_of_drives
        self._one_tick = None
        self.work = WorkMeter(powers, self._integrator, smooth=self.contact is None)
        return self.work

    def work_done(self) -> tuple[Array, Array]:
        """Work so far [J], and how wrong it may be: see `WorkMeter.work`."""
        assert self.work is not None
        if not self.work.looks_ahead or self.undo is not None:
            done, error = self.work.work()
        else:
            undo = self.begin()  # it goes ahead a bit: an interrupt puts that back
            done, error = self.work.work()
            self.end(undo)
        if self.contact is not None:
            done = done.copy()
            done[DRIVES] += self.contact.arrays.work_of_drives - self._drives_before
        return done, error

    def cut_work(self) -> None:
        """End a stretch: from here on forces are others, or the method or the motion is."""
        if self.work is None:
            return
        if not self.work.looks_ahead or self.undo is not None:
            self.work.cut()
            return
        undo = self.begin()
        self.work.cut()
        self.end(undo)

    def warnings(self) -> tuple[str, ...]:
        """Give what the contact of the scene warns of, whatever the state."""
        return () if self.contact is None else self.contact.warnings

    def overlap_warnings(self) -> dict[tuple[int, int], str]:
        """Warn of pairs of bodies (scene indices) that have overlapped too deeply."""
        return {} if self.contact is None else self.contact.readout.overlap_warnings()

    def deepest_gap(self) -> float | None:
        """Give the smallest gap of two bodies that touched, at the start of any tick [m]."""
        return None if self.contact is None else self.contact.readout.deepest_gap()

    def contacts(self) -> Contacts:
        """Give the contacts of the last tick; none in a scene without contact."""
        return NO_CONTACTS if self.contact is None else self.contact.readout.contacts()

    def impacts(self, *, dt_ns: int, start_ns: int) -> Impacts:
        """
        Give the impacts since they were last forgotten; none without impacts at their instants.

        dt_ns    : tick [ns]
        start_ns : where tick 0 of the kernel began [ns]
        """
        if self.contact is None:
            return NO_IMPACTS
        return self.contact.readout.read_impacts(dt_ns=dt_ns, start_ns=start_ns)

    def memory(self) -> Array:
        """Give what the integrator remembers beside the blocks, (n_rigid, rows); often nothing."""
        rows_kept = self._method.size // max(1, blocks(self._layout.n_rigid) * LANES)
        if self._integrator.remembers is None or not rows_kept:
            return np.zeros((self._layout.n_rigid, 0))
        return gather(self._method, LANES * rows_kept, 0, rows_kept, self._layout.n_rigid)

    def remembered(self) -> Array:
        """
        Give all that the next tick depends on beside the blocks, in one row: `memory`, and the
        impulses of contacts.
        """
        own = self.memory().reshape(-1)
        return (
            own
            if self.contact is None
            else np.concatenate((own, self.contact.memory.remembered()))
        )

    def recall(self, numbers: Array) -> None:
        """
        Restore what `remembered` gave; without numbers begin anew from the orientations.

        Raises ValueError for other numbers.
        """
        if self.contact is not None:
            self.contact.memory.recall(numbers)
        elif self._integrator.remembers is not None:
            count = self._layout.n_rigid
            values = numbers.reshape(count, -1) if numbers.size else self._method_rows()
            self._method[:] = self._blocks_of(values)
        elif numbers.size:
            raise ValueError(f'{8 * numbers.size} bytes more than its motion, which is all')

    def _blocks_of(self, coefficients: Array) -> Array:
        width = coefficients.shape[1]
        array = np.zeros(blocks(self._layout.n_rigid) * LANES * width)
        if array.size:
            scatter(array, LANES * width, 0, coefficients)
        return array

    def _take_arguments(self) -> None:
        self._one_tick = None
        self._arguments = (
            self._layout.n_moving,
            self._layout.n_rigid,
            argument(self.translation),
            argument(self.rotation),
            argument(self._method),
            argument(self._workspace),
            *self._elements.arguments,
        )

    def set_held(self, table: Array) -> Array:
        """
        Take over what is held: `table` turns with the bodies, the rest is in the blocks already.

        returns : where the table lies from now on
        """
        if table is self._elements.table:
            return table
        if len(table) == self._turning:
            self._elements.change_turning(table)
            return self._elements.table
        self._elements.set_turning(table)
        self._take_arguments()
        held = rows(self.translation, TRANSLATION, HELD_FORCE, 3)  # as the free kernel wants them
        rows(self.translation, TRANSLATION, FORCE, 3)[:] = held
        held = rows(self.rotation, ROTATION, HELD_TORQUE, 3)
        rows(self.rotation, ROTATION, TORQUE, 3)[:] = held
        self._turning = len(table)  # last: an interrupt before it lets all be done again
        return self._elements.table

    def _free_kernel(self) -> Callable[..., Any]:
        if self._free is None:
            self._free = (
                self._scheme.free(self._kernel_name)
                if self.contact is None
                else self.contact.kernel('', None, False)
            )
        assert self._free is not None
        return self._free

    def _coupled_kernel(self) -> Callable[..., Any]:
        if self._coupled is None:
            self._coupled = self._made_for_elements()
        assert self._coupled is not None
        return self._coupled

    def _made_for_elements(self) -> Callable[..., Any]:
        """Make the kernel for the elements that act."""
        elements = self._elements
        if self.contact is not None:
            return self.contact.kernel(
                f'forces_{elements.kernel_name}',
                elements.evaluate(),
                elements.depends_on_velocity,
            )
        more: dict[str, Any] = {}
        if self._integrator.wants_derivatives:
            more['derivatives'] = elements.derivatives()
        return self._scheme.coupled(
            self._kernel_name,
            scene=elements.kernel_name,
            evaluate=elements.evaluate(),
            velocity_dependent=elements.depends_on_velocity,
            **more,
        )

    def accelerations(self, tick: float, h: float) -> tuple[Array, Array]:
        """
        Evaluate everything that acts from a tick boundary on; the state stays as it is.

        returns : linear (n_moving, 3) [m/s^2] and angular (n_rigid, 3) [rad/s^2], core order,
                  world axes
        """
        elements = self._elements
        if elements.schedule is not None:
            elements.schedule.set(elements.numbers, tick, tick + SNAP, h)
        return accelerations_now(
            self._layout, elements, self.translation, self.rotation, time=tick * h
        )

    def _ready_workspace(self, h: float) -> None:
        """Work out what the integrator wants to know of the scene at this step."""
        self._one_tick = None
        if self._integrator.plan is None:
            self._workspace_step = h
            return
        made = self._workspaces.get(h)
        if made is None:
            made = self._integrator.plan(self._scene, self._layout, h)
        self._workspaces = {**dict([*self._workspaces.items()][-3:]), h: made}
        self._workspace = made
        workspace = argument(self._workspace)
        self._arguments = (
            *self._arguments[:WORKSPACE],
            workspace,
            *self._arguments[WORKSPACE + 1 :],
        )
        self._workspace_step = h

    def prepare(
        self, *, commands_in_body_axes: bool, progress: Callable[[str], None] | None
    ) -> None:
        """Compile the kernels that will be needed by advancing over no tick."""
        name = self._integrator.name
        wanted = []
        coupled = self._elements.names
        if not coupled:
            bodies = 'free bodies' if self.contact is None else 'bodies in contact'
            wanted.append((f'{name} for {bodies}', self._free_kernel))
        if coupled or commands_in_body_axes:
            forces = ', '.join([*coupled, 'commands in body axes'])
            wanted.append((f'{name} with {forces}', self._coupled_kernel))
        for text, kernel in wanted:
            if progress is not None:
                progress(text)
            self._ready_workspace(1.0)
            kernel()(0, 0.0 if self.is_timed else 0, 1.0, *self._arguments)
        self.end(self._begin_ticks())

    def advance(self, ticks: int, tick: float, h: float) -> int:
        """
        Advance over ticks of length h [s], the first of them being number `tick` since the start
        of the scene.

        returns : ticks done; fewer than asked where a state left the finite numbers, then the
                  state is the last good one
        """
        one_tick = self._one_tick
        if one_tick is not None and ticks == 1:
            usual, n, step, keep, call = one_tick
            if h == usual:
                keep()
                of_contact = None if self.contact is None else self.contact.memory.keep()
                self.undo = before = (self.tick, None, of_contact, None, None)
                try:
                    status = call(n, n * tick, step)
                except (ArithmeticError, ValueError) as error:
                    if not left_the_numbers(error):
                        raise
                    status = math.nan
                if status == 0.0:
                    if self.undo is not before:
                        raise SimulationBusy
                    self.tick += 1
                    self.undo = None
                    return 1
                if status is not NotImplemented:
                    self.cause = self._cause_of(status)
                    self._copy_back()
                    return 0
                self.undo = None  # a tick of another kind: nothing was done
        return self._advance_any(ticks, tick, h)

    def _advance_any(self, ticks: int, tick: float, h: float) -> int:
        """Do what `advance` does, whatever acts and however many ticks there are."""
        elements = self._elements
        kernel = self._free if elements.do_nothing else self._coupled
        if kernel is None:
            kernel = self._free_kernel() if elements.do_nothing else self._coupled_kernel()
        if self.contact is not None:
            self.contact.take_tick(h / self._substeps)
            self.contact.take_pulled(elements.pulled)
        if elements.schedule is None:
            done = self._advance(kernel, ticks, tick, h)
            if done == ticks == 1:
                self._note_one_tick(tick, h)
            return done
        done = 0
        while done < ticks:
            now = float(tick + done)
            whole, cuts = elements.schedule.cuts(now, h)
            if cuts:
                if not self._advance_in_pieces(kernel, now, cuts, h):
                    return done
                done += 1
                continue
            run = int(min(whole, ticks - done))
            elements.schedule.set(elements.numbers, now, now + run, h)
            got = self._advance(kernel, run, now, h, to_the_end=run == whole)
            if got == whole:
                self.cut_work()
            done += got
            if got < run:
                break
        return done

    def _note_one_tick(self, tick: float, h: float) -> None:
        """
        Note how the tick that was done is done again, for who looks at each one; `_one_tick` is
        None again where arguments, method, or who looks at the work are others.
        """
        looks = self.work is not None or (
            self.contact is not None and self.contact.readout.has_events
        )
        if self._keep is None or looks or self._parts:
            return
        n, call = self._substeps, self._call
        if self.contact is None and self._elements.do_nothing and self._layout.n_moving <= BRIEF:
            kernel, arguments = self._called
            call = prepared(kernel, (n, n * tick, h / n), arguments, brief=True)
        self._one_tick = h, n, h / n, self._keep, call

    def _advance_in_pieces(
        self, kernel: Callable[..., Any], tick: float, cuts: list[float], h: float
    ) -> bool:
        """Advance over one tick in pieces between instants; on failure return to its start."""
        before = self.begin()
        instants = [tick, *cuts, tick + 1.0]
        lengths = [(end - begin) * h for begin, end in itertools.pairwise(instants)]

        def between(piece: int) -> float:
            well = self._go_between(kernel, instants[piece], instants[piece + 1], h)
            return 0.0 if well else math.nan

        if self.contact is None:
            status = next((s for s in map(between, range(len(lengths))) if s != 0.0), 0.0)
        else:
            step, contact = h / self._substeps, self.contact

            def advance(is_cut: bool) -> float:
                if is_cut:
                    return contact.pieces.in_pieces(step, lengths, between)
                whole = partial(self._go_whole, kernel, tick, h)
                return contact.pieces.in_pieces(step, [h], whole)

            bodies = self._elements.bodies_at(cuts, h)
            status = contact.islands.advance_cut(bodies, step, self._arguments[2:4], advance)
        if status != 0.0:
            self._copy_back()
            return False
        self.cut_work()
        self.end(before, 1)
        return True

    def _go_whole(self, kernel: Callable[..., Any], tick: float, h: float, _piece: int) -> float:
        """Advance over a whole tick all the same, for who does not feel what cuts it."""
        schedule, n = self._elements.schedule, self._substeps
        assert schedule is not None
        schedule.set(self._elements.numbers, tick, tick + 1.0, h)
        return 0.0 if self.steps(kernel, n, n * tick, h / n) else math.nan

    def _go_between(self, kernel: Callable[..., Any], begin: float, end: float, h: float) -> bool:
        """Advance from one place to another [tick], between which no instant lies."""
        schedule, piece = self._elements.schedule, (end - begin) * h
        assert schedule is not None
        schedule.set(self._elements.numbers, begin, end, h)
        self.cut_work()
        return self._go(kernel, 1, begin * h / piece, piece, to_the_end=True)

    def _advance(
        self,
        kernel: Callable[..., Any],
        ticks: int,
        tick: float,
        h: float,
        *,
        to_the_end: bool = False,
    ) -> int:
        """
        Advance over ticks between which nothing begins or ends; `to_the_end`: but behind them.
        """
        done, n = 0, self._substeps
        while done < ticks:
            chunk = ticks - done if ticks - done < self._chunk else self._chunk
            if self.work is None:
                before = self._begin_ticks()
                well = self.steps(kernel, n * chunk, n * (tick + done), h / n)
            else:
                before = self.begin()
                last = to_the_end and done + chunk == ticks
                well = self._go(kernel, chunk, tick + done, h, to_the_end=last)
            if not well:
                self._copy_back()
                if chunk == 1:
                    return done
                return done + self._creep(kernel, chunk, tick + done, h)
            self.end(before, chunk)
            done += chunk
        return done

    def _creep(self, kernel: Callable[..., Any], ticks: int, tick: float, h: float) -> int:
        """Advance tick by tick up to the one that fails."""
        for done in range(ticks):
            before = self.begin()
            if not self._go(kernel, 1, tick + done, h, to_the_end=False):
                self._copy_back()
                return done
            self.end(before, 1)
        return ticks

    def _go(
        self, kernel: Callable[..., Any], ticks: int, tick: float, h: float, *, to_the_end: bool
    ) -> bool:
        """Advance over ticks, looking at the power where somebody asked and there is any."""
        n = self._substeps
        if self.work is None or self.work.powers.idle:
            return self.steps(kernel, n * ticks, n * tick, h / n)
        motion = _Motion(self, kernel)
        return self.work.follow(motion, ticks, tick, h, to_the_end=to_the_end)

    def steps(self, kernel: Callable[..., Any], count: int, first: float, h: float) -> bool:
        """Make steps of the method of a length [s], the first beginning at first * h."""
        if h != self._workspace_step:
            self._ready_workspace(h)
        of_kernel, arguments = self._called
        if of_kernel is not kernel or arguments is not self._arguments:
            call = prepared(kernel, (count, first, h), self._arguments)
            called = (kernel, self._arguments)
            parts = self._parts_of(kernel, (count, first, h))
            change = {'_call': call, '_called': called, '_parts': parts}
            self.__dict__.update(change)  # one call of C: all or none
        try:
            if self._parts and count * self._layout.n_moving >= WORTH_THREADS:
                status = sum(self._side_by_side.call(self._parts, (count, first, h)))
            else:
                status = self._call(count, first, h)
            if status is NotImplemented:
                status = kernel(count, first, h, *self._arguments)
            if status == 0.0:
                return True
            self.cause = self._cause_of(status)
            return False
        except (ArithmeticError, ValueError) as error:
            if not left_the_numbers(error):
                raise
            return False

    def _cause_of(self, status: float) -> str:
        """Say why a kernel stopped early; empty: a state left the finite numbers."""
        if status == TOO_MANY_EVALUATIONS:
            at = gather(self.translation, TRANSLATION, POSITION, 3, self._layout.n_moving)
            return too_many_evaluations(float(np.linalg.norm(at, axis=1).max()))
        return self._integrator.failure if status == DID_NOT_CONVERGE else ''

    def _parts_of(self, kernel: Callable[..., Any], first: tuple[Any, ...]) -> list[Any]:
        """
        Cut the work of a kernel into parts that have nothing to do with each other: free bodies,
        some blocks each. None where there is but one, or where blocks meet.
        """
        layout, scheme = self._layout, self._scheme
        count = min(blocks(layout.n_moving), PARTS_OF_EACH * threads())
        meet = kernel is not self._free or self.contact is not None
        if meet or threads() == 1 or count < 2 or not COMPILED:
            return []
        if not isinstance(scheme, Splitting) or self._integrator.remembers is not None:
            return []  # it keeps what all blocks need in its workspace
        rigid = max(1, blocks(layout.n_rigid))
        width = self._method.size // rigid
        edges = [blocks(layout.n_moving) * part // count for part in range(count + 1)]
        parts = []
        for begin, end in itertools.pairwise(edges):
            bodies = (
                min(all_of_them, LANES * end) - LANES * begin
                for all_of_them in (layout.n_moving, layout.n_rigid)
            )
            last = (
                *(max(0, number) for number in bodies),
                self.translation[begin * TRANSLATION : end * TRANSLATION],
                self.rotation[begin * ROTATION : end * ROTATION],
                self._method[begin * width : end * width],
                *self._arguments[WORKSPACE:],
            )
            parts.append(prepared(kernel, first, last))
        return parts

    def _copy_back(self) -> None:
        """
        Return to an earlier state; note which body left the finite numbers: of several, as where
        one takes along whom it meets, the fastest there.
        """
        points = gather(self.translation, TRANSLATION, 0, 6, self._layout.n_moving)
        turns = gather(self.rotation, ROTATION, 0, 7, self._layout.n_rigid)
        bad = ~np.isfinite(points).all(axis=1)
        bad[: self._layout.n_rigid] |= ~np.isfinite(turns).all(axis=1)
        culprits = np.flatnonzero(bad)
        self.put_back()
        speeds = self._speeds()
        self._bad = int(
            min(culprits, key=lambda i: (-speeds[i], self._layout.moving[i]), default=0)
        )

    @np.errstate(all='ignore')  # a state on its way to infinity
    def _speeds(self) -> Array:
        """Speeds of the bodies that would have their kinetic energies [m/s], core order."""
        layout = self._layout
        mass = layout.masses
        momentum = gather(self.translation, TRANSLATION, MOMENTUM, 3, layout.n_moving)
        squared = np.sum((momentum / mass[:, None]) ** 2, axis=1)
        turning = gather(self.rotation, ROTATION, ANGULAR_MOMENTUM, 3, layout.n_rigid)
        least = layout.moments.min(axis=1, initial=math.inf)
        squared[: layout.n_rigid] += np.sum(turning**2, axis=1) / (least * mass[: layout.n_rigid])
        return np.nan_to_num(np.sqrt(squared), nan=math.inf)

    def first_diverged(self) -> int:
        """Core index of the first body, in scene order, that left the finite numbers."""
        return self._bad

    @np.errstate(over='ignore')  # the next tick diverges
    def apply_impulse(self, core: int, linear: Array, angular: Array) -> None:
        """Add to momentum [N s] and angular momentum [N m s], world axes."""
        block, lane = divmod(core, LANES)
        if core < self._layout.n_rigid:
            q = self.orientation(core)
            linear, angular = self._elements.pivots.about_pivot(core, linear, angular, q)
        place = (block, slice(None), lane)
        momentum = rows(self.translation, TRANSLATION, MOMENTUM, 3)
        new = [(momentum, place, momentum[place] + linear)]
        if core < self._layout.n_rigid:
            momentum = rows(self.rotation, ROTATION, ANGULAR_MOMENTUM, 3)
            new.append((momentum, place, momentum[place] + angular))
        # in one call of C: an interrupt comes before both or after both
        deque(itertools.starmap(setitem, new), maxlen=0)

    def place(self, placed: PlacedRows) -> None:
        """
        Put a body elsewhere; what the integrator and its contacts remember of it begins anew.
        Between `begin` and `end`.
        """
        block, lane = divmod(placed.core, LANES)
        for array, size, values in (
            (self.translation, TRANSLATION, placed.translation),
            (self.rotation, ROTATION, placed.rotation),
        ):
            for offset, new in values.items():
                rows(array, size, offset, len(new))[block, :, lane] = new
        if self._integrator.remembers is not None and ORIENTATION in placed.rotation:
            memory = self._method_rows()[placed.core]
            kept = rows(self._method, LANES * len(memory), 0, len(memory))
            kept[block, :, lane] = memory
        if self.contact is not None:
            self.contact.memory.forget_body(placed.core)

    def orientation(self, core: int) -> Array:
        """Quaternion (4,) of the principal axes of a rigid body."""
        block, lane = divmod(core, LANES)
        return rows(self.rotation, ROTATION, ORIENTATION, 4)[block, :, lane].copy()

    @property
    def start(self) -> tuple[Array, Array]:
        """Blocks of translation and rotation at the start of the scene."""
        (translation, rotation, *_), _ = self._start
        return translation, rotation

    def reset(self) -> None:
        """Return to the start of the scene."""
        self._return_to(self._start)


def _nothing_yet(_count: int, _first: float, _h: float) -> Any:
    """Stand for a kernel with its arguments before there is one."""
    return NotImplemented


class _Motion:
    """A stepper with one kernel and method, as `WorkMeter` takes it."""

    def __init__(self, stepper: Stepper, kernel: Callable[..., Any]) -> None:
        self._stepper = stepper
        self._kernel = kernel
        self.integrator = stepper._integrator
        self.translation = argument(stepper.translation)
        self.rotation = argument(stepper.rotation)
        self.snapshot = stepper._snapshot
        self.return_to = stepper._return_to

    def steps(self, count: int, first: float, h: float) -> bool:
        """Make steps of the method of a length [s], the first beginning at first * h."""
        stepper = self._stepper
        if stepper._integrator is not self.integrator:
            return False  # its arrays are another method's by now
        return stepper.steps(self._kernel, count, first, h)


def _contact_world(scene: Scene, layout: Layout, integrator: Integrator) -> Any:
    """Make the contact world of a scene; None where nothing touches."""
    if scene.contact.get('mode', 'none') == 'none':
        return None
    from rigid_body_sim.physics.contact.world import ContactWorld  # only what a scene needs

    return ContactWorld(scene, layout, integrator)
