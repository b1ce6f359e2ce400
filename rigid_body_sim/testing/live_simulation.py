# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A running node, as the test sees it: commands in, states out, controllers in lock-step, the bag.

Nothing here waits for a fixed time. Each wait ends when what it is for has come, when the node has
ended, or after `PATIENCE`.
"""

from __future__ import annotations

import re
import time
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.recording.topics import COMMAND_TYPES, body_topic
from rigid_body_sim.ros.lockstep import parted
from rigid_body_sim.ros.partner import BodyState, States, encoded
from rigid_body_sim.ros.peer import Peer
from rigid_body_sim.runs.commands import NO_VECTOR
from rigid_body_sim.testing.failures import NodeFailure, told_at_the_caller, with_last_lines
from rigid_body_sim.testing.given import GivenScene, parameter_file, scene_file
from rigid_body_sim.testing.node_process import NodeProcess
from rigid_body_sim.testing.states import StateCollector, told
from rigid_body_sim.testing.surroundings import of_child
from rigid_body_sim.testing.wrench import Wrench, as_wrench, message_of

PATIENCE = 60.0  # [s] of wall time for one state or word; a busy machine takes a few
GLANCE = 0.05  # [s] between looks whether the node is there
REPORTS = 0.1  # [s] of wall time between two diagnostics, which confirm commands
NODE = 'rigid_body_sim'
_TICK = re.compile(r'\btick (\d+)')

Controller = Callable[[States], Mapping[str, Any] | None]


class LiveSimulation:
    """
    One node and a peer of it in this process; made by the fixture `simulation`.

    domain    : number of their DDS domain
    namespace : of the node
    folder    : where it runs
    has_ended : whether it is over
    times     : [s] of wall time that each phase took: ready, connected, lockstep, ended
    """

    def __init__(
        self,
        scene: Any,
        *,
        lockstep: Iterable[str] = (),
        namespace: str = '',
        hear: Iterable[str] | None = None,
        parameters: Mapping[str, Any],
        folder: Path,
        domain: int,
    ) -> None:
        if isinstance(lockstep, str):
            lockstep = [lockstep]
        self.domain, self.folder = domain, folder
        self.namespace = f'/{namespace.strip("/")}' if namespace.strip('/') else ''
        self.times: dict[str, float] = {}
        self._is_closed = False
        self.has_ended = False
        self._lockstep = {self._absolute(name): name for name in lockstep}
        # topic -> its name as given; one may be in the list for several frames
        self._answering = {parted(own)[0]: parted(name)[0] for own, name in self._lockstep.items()}
        self._scene: GivenScene = scene_file(scene, folder)
        self._resumes = not self._lockstep and 'start_paused' not in parameters
        self._parameters = self._completed(parameters)
        self._collector = StateCollector(self._heard(hear), namespace=self.namespace)
        self._coming: deque[States] = deque()
        self._newest: States | None = None
        self._least = 0  # [ns] stamp below which a state is out of date
        # [ns] between the states that wait for an answer; 1: all of them do
        self._period = round(float(self._parameters.get('lockstep_period', 0.0)) * 1e9) or 1
        self._answered = -1  # [ns] stamp of the state that was answered last
        self._answers: list[tuple[str, bytes]] = []
        self._begin = time.monotonic()
        words = ['--params-file', str(parameter_file(self._parameters, folder))]
        if self.namespace:
            words += ['-r', f'__ns:={self.namespace}']
        self._process = NodeProcess(words, folder=folder, environment=of_child(domain))
        try:  # while it starts
            self._peer = Peer(domain, self._collector.types, self._collector.add)
            for topic in self._answering:
                kind = topic.rpartition('/')[2]
                if kind in COMMAND_TYPES:
                    self._peer.offer(topic, COMMAND_TYPES[kind])
        except BaseException:
            self._process.kill()
            raise

    def _completed(self, given: Mapping[str, Any]) -> dict[str, Any]:
        own: dict[str, Any] = {
            'scene': self._scene.path,
            'record': True,
            'record_path': self.folder / 'bag',
            'diagnostics_period': REPORTS,
        }
        if self._lockstep:
            own |= {
                'step_mode': 'lockstep',
                'lockstep_topics': list(self._lockstep.values()),
                'real_time_factor': 0.0,
            }
        elif self._resumes:
            own['start_paused'] = True
        return {**own, **given}

    def _heard(self, asked: Iterable[str] | None) -> tuple[str, ...]:
        bodies = self._scene.bodies
        names = bodies if asked is None else tuple(dict.fromkeys(asked))
        if not names:
            raise NodeFailure('hear: name at least one body')
        for name in names:
            self._need_body(name)
        return names

    def _need_body(self, name: str) -> None:
        bodies = self._scene.bodies
        if name not in bodies:
            known = ', '.join(bodies[:20])
            raise NodeFailure(f'no body is named {name!r}; the scene has: {known}')

    def _absolute(self, name: str) -> str:
        return name if name.startswith('/') else f'{self.namespace}/{name}'

    def wait_until_ready(self) -> None:
        """Come back when node and peer hear each other and the first states are there."""
        self._process.wait_until_ready()
        self.times['ready'] = time.monotonic() - self._begin
        self._until(lambda: self._peer.is_connected, 'its topics')
        self._until(lambda: self._newest is not None, 'its first states')
        if self._resumes:
            self.call('pause', False)
        self.times['connected'] = time.monotonic() - self._begin - self.times['ready']

    @property
    def said(self) -> str:
        """What the node wrote so far."""
        return self._process.said

    @property
    def pid(self) -> int:
        """Number of the node's process."""
        return self._process.pid

    @property
    def where(self) -> str:
        """Say how far it came."""
        reached = 'no state heard' if self._newest is None else f't = {self._newest.time:.9g} s'
        return f'domain {self.domain}, {reached}'

    @property
    @told_at_the_caller
    def time(self) -> float:
        """[s] of simulation, of the newest state."""
        return self._state().time

    @told_at_the_caller
    def state(self, body: str) -> BodyState:
        """
        Newest state of a body; after a `call`, of what the call did.
        """
        self._need_body(body)
        return self._state()[body]

    @told_at_the_caller
    def until(self, predicate: Callable[[States], Any], seconds: float) -> States:
        """
        Wait until something holds; give the first state of which it does.

        predicate : asked of every state from the newest on
        seconds   : of simulation, from that one on; NodeFailure when they are over
        """
        if self._lockstep:
            raise NodeFailure(
                'until: this simulation waits for its controller; use lockstep(f, until)'
            )
        state = self._state()
        limit = state.stamp + round(seconds * 1e9)
        self._coming.clear()
        while not predicate(state):
            if state.stamp >= limit:
                raise NodeFailure(
                    f'it did not hold within {seconds:g} s of simulation:\n{told(state)}'
                )
            self._until(lambda: self._coming, 'the next state')
            state = self._coming.popleft()
        return state

    @told_at_the_caller
    def lockstep(self, controller: Controller, until: float) -> States:
        """
        Let a function answer each state, up to a time of simulation; give the state there.

        controller : state -> command of each topic of the list, by its name: three numbers for a
                     force or torque, six or a `Wrench` for the others, or a message; what is
                     left out is zero.
                     It must depend on states and on itself alone.
        until      : [s] of simulation; the state of that time is not answered, so that a second
                     call goes on from it
        """
        if not self._lockstep:
            raise NodeFailure(
                'lockstep: this simulation runs by itself; start it with lockstep=[…]'
            )
        begin = time.monotonic()
        self._until(lambda: all(map(self._peer.is_heard, self._answering)), 'its ears')
        limit = round(until * 1e9)
        while (state := self._due()).stamp < limit:
            answers = self._messages(state, controller(state))
            self._answered, self._answers = state.stamp, answers
            self._coming.popleft()
            self._send_answers()
        self.times['lockstep'] = self.times.get('lockstep', 0.0) + time.monotonic() - begin
        return state

    def _due(self) -> States:
        """Wait for a state that was not answered yet; one that was gets the same answers again."""
        while True:
            while self._coming:
                state = self._coming[0]
                if state.stamp > self._answered and not state.stamp % self._period:
                    return state
                self._coming.popleft()
                if state.stamp == self._answered:
                    self._send_answers()
            self._until(lambda: self._coming, 'the next state in lock-step')

    def _send_answers(self) -> None:
        for topic, data in self._answers:
            self._peer.send(topic, data)

    def _messages(self, state: States, given: Mapping[str, Any] | None) -> list[tuple[str, bytes]]:
        commands = {} if given is None else {self._absolute(k): v for k, v in given.items()}
        if strangers := commands.keys() - self._lockstep.keys():
            raise ValueError(
                f'the controller answers on {", ".join(sorted(strangers))}; lock-step waits for: '
                f'{", ".join(self._lockstep.values())}'
            )
        answers = []
        for entry, name in self._lockstep.items():
            topic, frame = parted(entry)
            path, _, kind = topic.rpartition('/')
            where = f'the controller, at t = {state.time:.9g} s, for {name}'
            command, body = commands.get(entry), path.rpartition('/')[2]
            if hasattr(command, 'header'):
                data = encoded(entry, command, state.stamp)
            else:
                wrench = as_wrench(kind, command, where=where)
                if frame and wrench.frame == 'world':
                    wrench = replace(wrench, frame=frame)
                data = message_of(kind, wrench, body=body, stamp=state.stamp)
            answers.append((topic, data))
        return answers

    @told_at_the_caller
    def force(self, body: str, force: Sequence[float], frame: str = 'world') -> None:
        """Hold a force [N] at the centre of mass, for `command_timeout`."""
        self._command(body, 'force', Wrench(force=force, frame=frame))

    @told_at_the_caller
    def torque(self, body: str, torque: Sequence[float], frame: str = 'world') -> None:
        """Hold a torque [N m], for `command_timeout`."""
        self._command(body, 'torque', Wrench(torque=torque, frame=frame))

    @told_at_the_caller
    def wrench(
        self,
        body: str,
        force: Sequence[float] = NO_VECTOR,
        torque: Sequence[float] = NO_VECTOR,
        frame: str = 'world',
    ) -> None:
        """Hold a force [N] and a torque [N m], for `command_timeout`."""
        self._command(body, 'wrench', Wrench(force, torque, frame))

    @told_at_the_caller
    def impulse(
        self,
        body: str,
        linear: Sequence[float] = NO_VECTOR,
        angular: Sequence[float] = NO_VECTOR,
        frame: str = 'world',
    ) -> None:
        """Push once: [N s] and [N m s], at the next tick."""
        self._command(body, 'impulse', Wrench(linear, angular, frame))

    def _command(self, body: str, kind: str, wrench: Wrench) -> None:
        """Publish, and wait until the node says that it took it; NodeFailure if it refused."""
        self._need_body(body)
        topic = body_topic(self.namespace, body, kind, COMMAND_TYPES[kind])
        if topic.name in self._answering:
            raise NodeFailure(
                f'{self._answering[topic.name]} is a topic of lock-step: its commands are what '
                'the controller gives'
            )
        wrench = as_wrench(kind, wrench, where=f'{kind} for {body}')
        self._peer.offer(topic.name, topic.type)
        self._until(lambda: self._peer.is_heard(topic.name), f'a listener of {topic.name}')
        # before this one, all that was sent has been counted: each waited for that
        accepted, refused = self._counts(fresh=bool(self._lockstep))
        stamp = self._newest.stamp if self._newest is not None else 0
        self._peer.send(topic.name, message_of(kind, wrench, body=body, stamp=stamp))
        self._until(lambda: sum(self._counts()) > accepted + refused, 'word of the command')
        if self._counts()[1] > refused:
            raise NodeFailure(f'the node refused: {self._peer.health().get("last refusal")}')

    def _counts(self, *, fresh: bool = False) -> tuple[int, int]:
        """Numbers of commands that the node has accepted and refused, by its last report."""
        for _ in range(2 if fresh else 0):  # one may have been under way
            self._peer.forget_health()
            self._until(self._peer.health, 'diagnostics')
        self._until(self._peer.health, 'diagnostics')
        health = self._peer.health()
        return int(health['accepted commands']), int(health['refused commands'])

    @told_at_the_caller
    def call(self, name: str, request: Any = None, kind: Any = None) -> Any:
        """
        Call a service of the node.

        name    : pause, step, reset, record; or any other, below the node unless it begins with /
        request : True or False for pause and record
        kind    : type of another service; `request` is then one of its requests
        returns : what the node answered: the text, NodeFailure if it refused; of another service
                  the response
        """
        self._need_running()
        service = name if name.startswith('/') else f'{self.namespace}/{NODE}/{name}'
        if name == 'reset':
            self._look(0.0)
            self._collector.forget()
            self._coming.clear()
            self._newest = None
        response = self._peer.ask(service, request, kind, wait=self._word_of(f'service {name}'))
        if kind is not None:
            return response
        if not response.success:
            raise NodeFailure(f'the node refused {name}: {response.message}')
        if tick := _TICK.search(response.message):
            self._least = self._published(int(tick.group(1)), exactly=name == 'reset')
        return response.message

    def _published(self, tick: int, *, exactly: bool) -> int:
        """Give the stamp of the last state that is published up to a tick [ns]."""
        from rigid_body_sim.ros.parameters import PARAMETERS
        from rigid_body_sim.runs.run import publish_every

        default = next(entry.default for entry in PARAMETERS if entry.name == 'publish_rate')
        rate = self._parameters.get('publish_rate', default)
        dt_ns = round(self._parameters.get('dt', 0) * 1e9) or self._scene.dt_ns
        return (tick if exactly else tick - tick % publish_every(rate, dt_ns)) * dt_ns

    @told_at_the_caller
    def set(self, name: str, value: Any) -> None:
        """Set a live parameter of the node; NodeFailure, with its reason, if it refuses."""
        self._need_running()
        if isinstance(value, int) and not isinstance(value, bool):
            from rigid_body_sim.ros.parameters import PARAMETERS

            doubles = {entry.name for entry in PARAMETERS if isinstance(entry.default, float)}
            value = float(value) if name in doubles else value
        node = f'{self.namespace}/{NODE}'
        reason = self._peer.set(node, name, value, wait=self._word_of(f'parameter {name}'))
        if reason:
            raise NodeFailure(f'the node refused {name} = {value!r}: {reason}')

    def _state(self) -> States:
        """Give the newest state, not older than the last answer of the node."""
        self._look(0.0)
        self._until(
            lambda: self._newest is not None and self._newest.stamp >= self._least, 'a state'
        )
        assert self._newest is not None
        return self._newest

    def _look(self, seconds: float) -> bool:
        """Take what came; whether a state did."""
        self._need_running()
        self._peer.hear(seconds)
        states = self._collector.take()
        if states:
            self._coming.extend(states)
            self._newest = states[-1]
            if not self._lockstep and len(self._coming) > 100_000:
                self._coming.popleft()
        return bool(states)

    def _until(self, holds: Callable[[], Any], what: str) -> None:
        """Wait until something holds; NodeFailure if the node ends, or it takes too long."""
        wait = self._patience(what, PATIENCE)
        while not holds():
            wait(self._look(GLANCE))

    def _patience(self, what: str, seconds: float) -> Callable[[bool], None]:
        """Return what raises when the node has ended, or at the end of some seconds."""
        deadline = time.monotonic() + seconds

        def wait(is_alive: bool) -> None:
            if not is_alive:
                self._process.check(f'while the test waited for {what}')
            if time.monotonic() > deadline:
                late = f'{what} did not come within {seconds:g} s, {self.where}'
                raise NodeFailure(with_last_lines(late, self.said))

        return wait

    def _word_of(self, what: str) -> Callable[[], None]:
        """Return what waits for the answer of a service: a step may be many ticks."""
        wait = self._patience(f'the answer of {what}', 10.0 * PATIENCE)
        return lambda: wait(False)

    def _need_running(self) -> None:
        if self.has_ended:
            raise NodeFailure('this simulation has ended; what it did is in bag()')

    @told_at_the_caller
    def end(self) -> None:
        """End the node by SIGINT; NodeFailure unless it exits with 0. Once is enough."""
        if self.has_ended:
            return
        begin = time.monotonic()
        self.has_ended = True
        try:
            self._process.stop()
        finally:
            self.close()
            self.times['ended'] = time.monotonic() - begin

    def close(self) -> None:
        """Make sure that node and peer are gone, whatever happened."""
        self.has_ended = True
        try:
            self._process.kill()
        finally:
            if not self._is_closed:
                self._is_closed = True
                self._peer.close()

    @told_at_the_caller
    def bag(self, number: int = -1) -> Bag:
        """
        End the node and open what it recorded.

        number : of several, after a reset or ~/record; -1 the last, 0 the first
        """
        self.end()
        bags = self.bags
        if not bags:
            raise NodeFailure('nothing was recorded')
        return Bag(bags[number])

    @property
    def bags(self) -> list[Path]:
        """Paths of what was recorded so far, in order."""
        first = self.folder / Path(self._parameters['record_path'])
        later = re.compile(re.escape(first.name) + r'_(\d+)')
        numbers = {
            int(found.group(1)): path
            for path in first.parent.glob('*')
            if (found := later.fullmatch(path.name))
        }
        bags = [first] if first.exists() else []
        return bags + [numbers[number] for number in sorted(numbers)]
