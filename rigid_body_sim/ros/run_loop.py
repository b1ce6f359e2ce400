# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The thread that owns the world: waits for the wall clock, takes commands, advances, records,
publishes.

Every other thread reaches the run through two doors only: the inbox (commands) and the requests
(services, live parameters), both opened at tick boundaries. The wall clock decides when a tick
runs, never what it computes.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from rigid_body_sim.errors import RunError, UserError
from rigid_body_sim.physics.errors import SimulationDiverged
from rigid_body_sim.recording.batch import Batch
from rigid_body_sim.ros.bags import Bags
from rigid_body_sim.ros.health import Health
from rigid_body_sim.ros.inbox import Inbox
from rigid_body_sim.ros.lockstep_turns import LockstepTurns
from rigid_body_sim.ros.pacer import Pacer
from rigid_body_sim.ros.requests import Answer, Request, RequestQueue
from rigid_body_sim.ros.stepping import Steps, StepsAsked
from rigid_body_sim.runs import choices
from rigid_body_sim.runs.commands import Command
from rigid_body_sim.runs.pace import Pace
from rigid_body_sim.runs.run import Run, last_tick
from rigid_body_sim.stop_signals import STOP

LONGEST_SLEEP = 20_000_000  # [ns] without looking at requests
BREATH_EVERY = (
    2_000_000  # [ns] of work as fast as possible before other threads get the interpreter
)
BREATH = 1e-4  # [s] that is long enough for one of them to take it
BURST = 1000  # [tick] in one go; more delays commands, requests and the end
REPEAT = 1_000_000_000  # [ns] between two times that a paused run tells the states of its start
MOVING = {'step', 'steps', 'reset', 'record'}  # requests that leave no whole run where they fail
NEVER = 2**62  # [tick], and [ns] of the monotonic clock: later than all


@dataclass(frozen=True)
class Ending:
    """
    How a run ended.

    reason  : signal, stop_time, diverged, error
    problem : what to raise; None if all went well
    """

    reason: str
    problem: Exception | None = None


@dataclass(frozen=True)
class Visit:
    """
    A run between two ticks, for a request of the name `visit`: it may look, and ask for more.

    held     : paused by a person, or a client: until one lets it go on
    paused   : so, or because an answer in lock-step did not come
    stepping : steps are being done that somebody asked for
    inbox    : takes commands for the coming tick
    ask      : grants another request at this tick boundary, by name and value; none of MOVING
    """

    run: Run
    inbox: Inbox
    held: bool
    paused: bool
    stepping: bool
    ask: Callable[[str, object], Answer]


class RunLoop:
    """
    Steps one run until it is told to stop, reaches the stop time, or fails.

    publish : takes each packed batch
    report  : takes the figures, every `report_period` seconds
    stop    : set it to end the run as by a signal; a signal ends it too

    lockstep : how it waits for answers; None: time runs by itself
    say      : takes a line when somebody pauses the run, lets it go on, resets it or changes its
               pace: who finds it standing later can read when, and that it was asked for

    The states where it begins, at t = 0 or at a reset, are published before the first tick; while
    it is paused there, again every second, for whoever came later. A reset while a bag is open
    closes it and begins the next, whoever asked for the recording.
    """

    def __init__(
        self,
        run: Run,
        *,
        inbox: Inbox,
        bags: Bags,
        publish: Callable[[Batch], None],
        report: Callable[[Health], None],
        report_period: float,
        factor: float,
        stop_time: float,
        paused: bool,
        lockstep: LockstepTurns | None = None,
        say: Callable[[str], object] = lambda _: None,
    ) -> None:
        self.stop = False
        self.ending: Ending | None = None
        self.requests = RequestQueue(lockstep.wake if lockstep else None)
        self._lockstep = lockstep
        self._run = run
        self._inbox = inbox
        self._bags = bags
        self._publish = publish
        self._report = report
        self._say = say
        self._report_period = round(report_period * 1e9)
        self._paused = paused
        self._pauses = int(paused)
        self._pace = Pace()
        self._steps: Steps | None = None
        self._start: tuple[Batch, ...] = ()
        self._start_tick = run.simulation.tick
        self._breath = 0
        self._over = NEVER  # [ns] when the last tick was done
        now = time.monotonic_ns()
        self._next_repeat = now
        self._next_report = now + self._report_period
        self._pacer = Pacer(dt_ns=run.simulation.dt_ns, factor=factor, now=now)
        self._last_tick = last_tick(run.simulation.dt_ns)
        self._stop_tick = self._tick_of(stop_time)

    def run(self) -> None:
        """Run to the end and close the bag: the whole life of the thread."""
        ending = self._guarded(self._loop)
        self._over = time.monotonic_ns()  # to close a bag is no time of the run
        closing = self._guarded(lambda: self._close(ending.reason))
        self.ending = ending if ending.problem is not None else closing
        self._refuse_the_rest()
        self.tell_the_end()

    def tell_the_end(self) -> None:
        """Report the figures of the end; again when nobody judges commands any more."""
        self._guarded(lambda: self._tell(time.monotonic_ns()))

    def _guarded(self, work: Callable[[], str]) -> Ending:
        try:
            return Ending(work())
        except SimulationDiverged as problem:
            return Ending('diverged', problem)
        except Exception as problem:
            return Ending('error', problem)

    def _close(self, reason: str) -> str:
        self._bags.stop(reason)
        self._publish_rest()
        return reason

    def _loop(self) -> str:
        self._note_terms()
        self._restart()
        requests, simulation = self.requests, self._run.simulation
        turn = self._free_turn if self._lockstep is None else self._lockstep_turn
        self._publish_start()
        while not self._stopped:
            if requests.waiting:
                self._serve()
            if simulation.tick >= self._stop_tick:
                return 'stop_time'
            if simulation.tick >= self._last_tick:
                raise RunError(self._at_the_last_tick())
            now = time.monotonic_ns()
            if now >= self._next_report:
                self._tell(now)
                self._next_report = now + self._report_period
            if self._steps is not None:
                self._go_on(self._steps, now)
            elif self._paused:
                self._repeat_start(now)
                self._doze(now, min(self._next_report, self._next_repeat))
            else:
                turn(now)
        return 'signal'

    def _free_turn(self, now: int) -> None:
        """Do what is due by the wall clock, or wait for it."""
        pacer, left = self._pacer, self._end - self._run.simulation.tick
        if not pacer.factor:
            pacer.begin(self._advance(left), now)
            self._breathe(now)
        elif due := pacer.due(now):
            pacer.begin(self._advance(min(due, left)), now)
        else:
            self._doze(now, pacer.deadline)

    def _breathe(self, now: int) -> None:
        """Let other threads take the interpreter now and then."""
        if now >= self._breath:
            time.sleep(BREATH)
            self._breath = time.monotonic_ns() + BREATH_EVERY

    def _lockstep_turn(self, now: int) -> None:
        """Do a period if every topic has answered, or wait for it."""
        lockstep = self._lockstep
        assert lockstep is not None
        if lockstep.is_ready(now):
            self._advance_period(now)
        else:
            was = lockstep.timed_out
            lockstep.wait(now, self._next_report)
            if lockstep.timed_out != was:
                self._next_report = now

    def _advance_period(self, now: int) -> None:
        """Take the answers and go to the next instant; a signal or the stop time may be nearer."""
        lockstep, simulation = self._lockstep, self._run.simulation
        assert lockstep is not None
        tick = simulation.tick
        # within a period nobody is waited for: the stop time was there and has been put off
        commands = self._inbox.take()
        if tick % lockstep.period == 0:
            commands = lockstep.take(commands, now)
        end = min(lockstep.next_instant(tick), self._end)
        while simulation.tick < end and not self._stopped:
            self._do(end - simulation.tick, commands)
            commands = []
        self._pacer.count(simulation.tick - tick)

    @property
    def _stopped(self) -> bool:
        return self.stop or STOP.number != 0

    def _publish_start(self) -> None:
        """Publish the states where the run stands, before the first tick from there."""
        self._start, self._start_tick = self._run.start(), self._run.simulation.tick
        now = time.monotonic_ns()
        if self._lockstep is not None:
            self._lockstep.reach(self._start_tick, self._start, now)
        self._repeat_start(now, at_once=True)

    def _publish_rest(self) -> None:
        """Publish what no published tick will tell, as the run ends or is put back."""
        for batch in self._run.rest():
            self._publish(batch)

    def _repeat_start(self, now: int, *, at_once: bool = False) -> None:
        """Publish them again if it is time and no tick was done since."""
        if self._run.simulation.tick != self._start_tick:
            self._next_repeat = NEVER
        elif at_once or now >= self._next_repeat:
            for batch in self._start:
                self._publish(batch)
            self._next_repeat = now + REPEAT

    def _doze(self, now: int, until: int) -> None:
        """Sleep up to a time, less if a request comes."""
        if self._lockstep is not None:
            self._lockstep.rest(now, until)
            return
        left = until - now
        if left <= LONGEST_SLEEP:
            time.sleep(max(0, left) * 1e-9)
            return
        wake = self.requests.wake
        wake.wait((left - LONGEST_SLEEP // 2) * 1e-9 if left < 5 * LONGEST_SLEEP else 0.1)
        wake.clear()

    def _advance(self, ticks: int) -> int:
        """
        Do some of the ticks, but one only if commands came: then no tick was done if it fails.

        returns : ticks done
        """
        return self._do(ticks, self._inbox.take())

    def _do(self, ticks: int, commands: Sequence[Command]) -> int:
        run, tick = self._run, self._run.simulation.tick
        begin = time.perf_counter()
        output = run.advance(1 if commands else min(ticks, BURST, self._pace.ticks), commands)
        self._pace.note(output.tick - tick, time.perf_counter() - begin)
        self._bags.record(output, tick)
        if self._lockstep is not None:
            self._lockstep.reach(output.tick, output.batches, time.monotonic_ns())
        for batch in output.batches:
            self._publish(batch)
        return output.tick - tick

    def _serve(self) -> None:
        waiting = self.requests.waiting
        while waiting:
            request = waiting.popleft()
            try:
                answer = self._answer(request)
                if answer is not None:
                    request.give(answer)
            except Exception as problem:
                request.give(Answer(False, _said(problem)))
                if request.name in MOVING:
                    raise
                self._warn_of(request, problem)

    def _warn_of(self, request: Request, problem: Exception) -> None:
        """Say that a request failed, each failure once; it touched nothing that a run is."""
        text = f'{request.name}: failed, and the run goes on: {_said(problem)}'
        if text not in self._run.warnings:
            self._run.add_warning(text)

    def _refuse_the_rest(self) -> None:
        problem = self.ending.problem if self.ending else None
        self._break_off(str(problem) if problem else 'the run has ended')
        waiting = self.requests.waiting
        while waiting:
            waiting.popleft().give(Answer(False, 'the run has ended'))

    def _answer(self, request: Request) -> Answer | None:
        """Grant a wish or refuse it; None where the answer comes later."""
        match request.name:
            case 'pause':
                return self._pause(bool(request.value))
            case 'step':
                return self._step(request)
            case 'steps':
                return self._begin_steps(request)
            case 'stop_steps':
                if self._steps is not None and self._steps.request is request.value:
                    self._break_off('cancelled')
            case 'visit':
                request.value(self._visit())
            case 'quit':
                self.stop = True
            case 'reset':
                return self._reset()
            case 'record':
                return self._record(bool(request.value))
            case 'real_time_factor':
                self._set_factor(request.value)
            case 'stop_time':
                self._stop_tick = self._tick_of(request.value)
            case 'command_timeout':
                return self._set_command_timeout(request.value)
        return Answer(True, '')

    def _set_factor(self, factor: float) -> None:
        if factor != self._pacer.factor:
            self._say(f'real_time_factor: {factor:g} from {self._where()} on')
        self._pacer.set_factor(factor, time.monotonic_ns())
        self._restart()

    def _set_command_timeout(self, seconds: float) -> Answer:
        if self._bags.is_open:
            return Answer(
                False,
                f'command_timeout: got {seconds:g} s while recording to {self._bags.path}; it '
                'cannot be changed there, because a replay could not know; call ~/record with '
                'false first',
            )
        self._run.command_timeout_ns = round(seconds * 1e9)
        self._note_terms()
        return Answer(True, '')

    def _tick_of(self, stop_time: float) -> int:
        return -(-round(stop_time * 1e9) // self._run.simulation.dt_ns) if stop_time else NEVER

    @property
    def _end(self) -> int:
        """The tick at which the run ends if nobody ends it."""
        return min(self._stop_tick, self._last_tick)

    def _at_the_last_tick(self) -> str:
        return (
            f'{self._run.simulation.scene.name}: the run has come to {self._where()}, the last '
            'tick that messages can bear: ROS stamps count less than 2^31 s, recordings less than '
            '2^32 ticks; start the node anew, with a longer dt if need be, or give a stop_time '
            'before it'
        )

    def _where(self) -> str:
        simulation = self._run.simulation
        return f'tick {simulation.tick}, {simulation.time:g} s'

    def _visit(self) -> Visit:
        timed_out = self._lockstep is not None and self._lockstep.timed_out

        def ask(name: str, value: object) -> Answer:
            answer = self._answer(Request(name, value))
            assert answer is not None  # those that are answered later are not asked for here
            return answer

        return Visit(
            self._run,
            self._inbox,
            held=self._paused,
            paused=self._paused or timed_out,
            stepping=self._steps is not None,
            ask=ask,
        )

    def _not_held(self) -> str:
        """
        Say why no steps can be asked for; empty where somebody has paused the run. One that waits
        too long for answers counts as paused, and goes on by itself with the last of them.
        """
        if self._paused:
            return ''
        lockstep = self._lockstep
        if lockstep is not None and lockstep.timed_out and (missing := lockstep.no_answer()):
            return f'{missing}, at {self._where()}'
        return f'not paused, at {self._where()}: call ~/pause with true first'

    def _begin_steps(self, request: Request) -> Answer | None:
        if refusal := self._not_held():
            return Answer(False, refusal)
        if self._steps is not None:
            return Answer(False, _still(self._steps))
        self._steps = Steps(request)
        self._restart()
        return None

    def _go_on(self, steps: Steps, now: int) -> None:
        """Do some of the steps that were asked for, or wait for what they need."""
        lockstep, tick = self._lockstep, self._run.simulation.tick
        if not steps.left:
            pass
        elif now < steps.due:
            self._doze(now, steps.due)
        elif lockstep is None:
            steps.note(self._advance(min(steps.stretch, self._end - tick)))
            self._breathe(now)
        elif missing := lockstep.no_answer():
            lockstep.wait(now, self._next_report)
            if lockstep.timed_out:
                self._break_off(missing)
                return
        else:
            self._advance_period(now)
            steps.note(int(self._run.simulation.tick == tick + lockstep.period))
        if not steps.left:
            self._break_off('')

    def _break_off(self, why: str) -> None:
        """End the steps that were asked for, if there are any; `why` not all of them were done."""
        steps, self._steps = self._steps, None
        if steps is not None:
            steps.end(why, self._where())

    def _pause(self, paused: bool) -> Answer:
        self._break_off('paused' if paused else 'resumed')
        said = f'{"paused" if paused else "running"} at {self._where()}'
        if paused != self._paused:
            self._pauses += paused
            self._say(f'pause: {said}')
        self._paused = paused
        self._restart()
        return Answer(True, said)

    def _note_terms(self) -> None:
        if self._lockstep is not None:
            self._lockstep.note(self._run.command_timeout_ns)

    def _restart(self) -> None:
        """Let the wall clock count from now on."""
        now = time.monotonic_ns()
        self._pacer.restart(now)
        if self._lockstep is not None:
            self._lockstep.restart(now, self._pacer.factor)

    def _step(self, request: Request) -> Answer | None:
        """Begin so many ticks, which others may break off; in lock-step do a period."""
        if refusal := self._not_held():
            return Answer(False, refusal)
        if self._steps is not None:
            return Answer(False, _still(self._steps))
        if self._lockstep is not None:
            return self._step_period(self._lockstep)
        request.value = StepsAsked(int(request.value))
        return self._begin_steps(request)

    def _step_period(self, lockstep: LockstepTurns) -> Answer:
        """Do one period, whose answers must be there: nobody waits for them here."""
        if missing := lockstep.no_answer():
            return Answer(False, f'{missing}, at {self._where()}')
        self._advance_period(time.monotonic_ns())
        return Answer(True, f'at {self._where()}')

    def _reset(self) -> Answer:
        lockstep, tick = self._lockstep, self._run.simulation.tick
        goes_on = tick if lockstep is None else lockstep.next_instant(tick)
        if goes_on > self._last_tick:
            return Answer(
                False,
                f'no reset at {self._where()}: it goes on at the next instant, tick {goes_on}, '
                f'and messages can bear ticks up to {self._last_tick}; start the node anew',
            )
        self._break_off('reset')
        recorded = self._bags.is_open
        self._bags.stop('reset')
        self._inbox.clear()
        self._publish_rest()
        self._run.reset(goes_on)
        said = f'reset at {self._where()}; time goes on'
        if recorded:
            said += f'; closed {self._bags.path}'
            begun = self._begin_bag()
            said += f'; {begun.message}'
            if not begun.granted:
                self._run.add_warning(begun.message)
        self._publish_start()
        self._next_report = 0  # at once: it tells whoever draws what depends on time
        # closing a bag waits for the disk, most of a second where both are busy: no tick's fault
        self._pacer.restart(time.monotonic_ns())
        self._say(said)
        return Answer(True, said)

    def _record(self, wanted: bool) -> Answer:
        if wanted == self._bags.is_open:
            state = f'recording to {self._bags.path}' if wanted else 'not recording'
            return Answer(True, f'already {state}')
        if not wanted:
            self._bags.stop('stopped')
            return Answer(True, f'closed {self._bags.path}')
        begun = self._begin_bag()
        return Answer(True, f'{begun.message} from {self._where()}') if begun.granted else begun

    def _begin_bag(self) -> Answer:
        """Begin the next bag; where it cannot be, the run goes on without one."""
        try:
            return Answer(True, f'recording to {self._bags.start()}')
        except (UserError, RunError, OSError) as error:
            return Answer(
                False, f'not recording from {self._where()} on: {error}; then call ~/record'
            )

    def _tell(self, now: int) -> str:
        self._report(self.health(now))
        return ''

    def health(self, now: int) -> Health:
        """Take the figures; for the thread of the loop, or when it has ended."""
        simulation, pacer = self._run.simulation, self._pacer
        problem = self.ending.problem if self.ending else None
        lockstep, inboxes = None, [self._inbox]
        if self._lockstep is not None:
            lockstep = self._lockstep.figures(now)
            inboxes.append(self._lockstep.gate.inbox)
        return Health(
            scene=simulation.scene.name,
            tick=simulation.tick,
            time=simulation.time,
            scene_began=simulation.time - simulation.scene_time,
            paused=self._paused or (lockstep is not None and lockstep.timed_out),
            pauses=self._pauses,
            lockstep=lockstep,
            factor_asked=pacer.factor,
            factor=0.0 if self._paused else pacer.factor_reached(min(now, self._over)),
            overruns=pacer.overruns,
            lags=pacer.lags,
            largest_lateness=pacer.largest_lateness * 1e-9,
            last_lateness=pacer.last_lateness * 1e-9,
            accepted=sum(inbox.accepted for inbox in inboxes),
            refused=sum((Counter(inbox.refused) for inbox in inboxes), Counter()),
            last_refusal=' '.join(filter(None, (inbox.last_refusal for inbox in inboxes))),
            drift=self._run.sample_drift(),
            balance=self._run.energy_balance(),
            kept=self._run.kept(),
            estimate=self._run.error_estimate(),
            warnings=tuple(self._run.warnings),
            bag=str(self._bags.path) if self._bags.is_open else '',
            deepest_gap=self._run.deepest_gap(),
            integrator=choices.method_text(simulation),
            looks=choices.looks_text(simulation),
            failure=str(problem) if problem else '',
        )


def _said(problem: Exception) -> str:
    """Give what is wrong, with its type where that is of no error of ours."""
    if isinstance(problem, UserError | RunError | SimulationDiverged):
        return str(problem)
    return f'{type(problem).__name__}: {problem}'


def _still(steps: Steps) -> str:
    return f'{steps.left} steps of another request are still to be done'
