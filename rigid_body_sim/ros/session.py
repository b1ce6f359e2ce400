# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The life of the node from the command line to its end.
"""

from __future__ import annotations

import gc
import os
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import rclpy
from rclpy.context import Context
from rclpy.exceptions import InvalidParameterTypeException
from rclpy.executors import SingleThreadedExecutor
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.logging import get_logger
from rclpy.signals import SignalHandlerOptions

from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.compile.kernels import warn_if_plain
from rigid_body_sim.recording.bag_writer import RecordingGone
from rigid_body_sim.recording.new_output import check_text
from rigid_body_sim.recording.topic_names import names_on_the_wire
from rigid_body_sim.ros import lockstep, standard
from rigid_body_sim.ros.bags import Bags, need_free
from rigid_body_sim.ros.domain import check_domain
from rigid_body_sim.ros.inbox import Inbox
from rigid_body_sim.ros.lockstep import Gate, Terms
from rigid_body_sim.ros.lockstep_turns import LockstepTurns
from rigid_body_sim.ros.middleware import deaf_to_itself
from rigid_body_sim.ros.node import NAME, SimNode
from rigid_body_sim.ros.parameters import Settings
from rigid_body_sim.ros.run_loop import Ending, RunLoop
from rigid_body_sim.runs.commands import topics_of
from rigid_body_sim.runs.recorder import recorded_topics
from rigid_body_sim.runs.run import (
    Run,
    RunSettings,
    need_numbers,
    publish_every,
    rate_note,
)
from rigid_body_sim.runs.simulation_of_scene import simulation_of
from rigid_body_sim.runs.view import ViewSettings
from rigid_body_sim.runs.viewing import check_view, marker_every
from rigid_body_sim.scene import load_scene
from rigid_body_sim.scene.shipped_scenes import find_scene
from rigid_body_sim.stop_signals import STOP

LOGGING = 'logging'  # of what the middleware says where it finds no folder for its logs
MOST_SHOWN = 12  # [bodies] named in the line that says that the node is ready
SHOWN = 4  # [topics] named in a line
if TYPE_CHECKING:
    from rigid_body_sim.ros.standard.services import Standard

SPIN = 0.1  # [s] between looks whether the run has ended or a signal came
SWITCH_INTERVAL = 5e-4  # [s] that a thread may keep the interpreter; Python's 5 ms make ticks late


def run_node(words: Sequence[str]) -> None:
    """
    Run the node to its end: stop_time, or a signal. Before it has a scene that is ready to run and
    its topics, a signal ends the process at once.

    words : arguments for ROS, from --ros-args on

    Raises UserError and InvalidModel for what cannot be used, RunError and SimulationDiverged for
    what failed on the way.
    """
    check_domain()
    for word in words:
        check_text(word, what='what ROS is told')
    context = Context()
    try:
        _session(words, context)
    finally:
        context.try_shutdown()


def _session(words: Sequence[str], context: Context) -> None:
    with _logged(NAME), deaf_to_itself(words):
        node = _make_node(words, context)
    try:
        with _logged(node.get_logger().name):
            run = _make_run(node)
            ending = _serve(node, run, context)
            if ending.problem is not None:
                raise ending.problem
        if node.is_crowd:
            _leave(context)
    finally:
        node.destroy_node()


def _leave(context: Context) -> None:
    """
    End the process here, with exit code 0: all was said, and the bags are closed.

    DDS takes thousands of endpoints apart one by one, against each other: a minute and more. So
    others learn by the lease (20 s with Fast DDS) that the node has gone.
    """
    context.try_shutdown()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(0)


@contextmanager
def _logged(name: str) -> Iterator[None]:
    """
    Put what fails into the log of ROS too: its file, and /rosout once there is a node. Not to the
    terminal, where the verb says it.
    """
    try:
        yield
    except Exception as error:
        sys.stderr.flush()
        terminal, nowhere = os.dup(2), os.open(os.devnull, os.O_WRONLY)
        try:
            os.dup2(nowhere, 2)
            get_logger(name).fatal(' '.join(str(error).split()))
        finally:
            os.dup2(terminal, 2)
            os.close(terminal)
            os.close(nowhere)
        raise


def _serve(node: SimNode, run: Run, context: Context) -> Ending:
    """Let the run meet its topics, services and bags, up to its end."""
    inbox = Inbox(run.rules)
    gate = _make_gate(node, run) if node.settings.step_mode == 'lockstep' else None
    bags = Bags(run, _record_path(node.settings))
    node.open_topics(run.topics, run.names, inbox, gate)
    STOP.keep()
    if node.settings.record:
        bags.start()
    try:
        ending = _run_to_the_end(node, run, context, inbox, bags, gate)
    finally:
        bags.stop('error')  # where the run did not come to closing it
    _say_the_end(node, ending, bags)
    return ending


def _run_to_the_end(
    node: SimNode, run: Run, context: Context, inbox: Inbox, bags: Bags, gate: Gate | None
) -> Ending:
    """Offer the services, and let the run go on until it has ended."""
    turns = _make_turns(node, run, gate) if gate is not None else None
    loop = _make_loop(node, run, inbox, bags, turns)
    try:
        node.serve(loop)
        more = standard.offer(node, loop, run, world_frame=node.settings.world_frame)
    except rclpy_implementation.RCLError as error:  # a service of another package has its name
        raise UserError(f'arguments for ROS: {_first_of(error)}; change the remapping') from None
    node.get_logger().info(_ready_line(node, run, bags))
    ending = _spin(node, loop, context, more)
    if turns is not None:
        turns.close()
    return ending


def _say_the_end(node: SimNode, ending: Ending, bags: Bags) -> None:
    """Sum the run up; as an error, with its reason, where it failed."""
    log, words = node.get_logger(), node.last_words()
    if ending.problem is None:
        log.info(f'{ending.reason}: {words}')
    else:
        log.error(f'{ending.reason}: {" ".join(str(ending.problem).split())}; {words}')
    if isinstance(ending.problem, RecordingGone):
        return  # said: nothing stands at its path
    if bags.path is not None and bags.torn:
        log.error(
            f'recorded in part: {bags.path}, without an ending, as the run failed before it could '
            f'be written; restore it with: bag recover {bags.path} -o NEW'
        )
    elif bags.path is not None:
        log.info(f'recorded: {bags.path}')


def _make_node(words: Sequence[str], context: Context) -> SimNode:
    try:
        rclpy.init(
            args=list(words), context=context, signal_handler_options=SignalHandlerOptions.NO
        )
        return SimNode(context)
    except InvalidParameterTypeException as error:  # of a parameter that every node has
        raise UserError(f'parameters: {error}') from None
    except (rclpy_implementation.RCLError, rclpy_implementation.UnknownROSArgsError) as error:
        if LOGGING in str(error):
            raise UserError(
                f'logs of ROS: {_first_of(error)}; it needs a folder for them: set ROS_LOG_DIR to '
                'one that can be written, or HOME'
            ) from None
        raise UserError(f'arguments for ROS: {_first_of(error)}; see: sim_node --help') from None


def _first_of(error: Exception) -> str:
    """Give what the middleware said, without the places in its sources."""
    return ' '.join(str(error).split()).partition(', at /')[0]


def _record_path(settings: Settings) -> Path | None:
    return _from_home(settings.record_path) if settings.record_path else None


def _from_home(path: str) -> Path:
    """Give the path that a parameter says: no shell has seen what stands behind its `:=`."""
    return Path(os.path.expanduser(path))  # noqa: PTH111  (that of Path fails without a home)


def _make_run(node: SimNode) -> Run:
    """Read the scene and compile what it needs, so that no tick has to wait for it."""
    warn_if_plain(node.warn)
    settings = node.settings
    scene = load_scene(find_scene(_from_home(settings.scene)))
    view = _view_settings(node)
    need_numbers(scene.name, check_view(scene, view, settings.world_frame))
    simulation = simulation_of(
        scene,
        integrator=settings.integrator or None,
        dt=settings.dt or None,
        progress=node.get_logger().info,
    )
    every = publish_every(settings.publish_rate, simulation.dt_ns)
    path = _record_path(settings)
    if path is not None:
        need_free(path)

    def progress(text: str) -> None:
        node.get_logger().info(f'preparing: {text} (compiled once per machine)')

    simulation.prepare(commands_in_body_axes=True, progress=progress)
    run = Run(
        simulation,
        RunSettings(
            namespace=node.get_namespace(),
            world_frame=settings.world_frame,
            command_timeout_ns=round(settings.command_timeout * 1e9),
            publish_every=every,
            estimate_error=settings.error_estimate,
            publish_contacts=settings.publish_contacts,
            view=replace(
                view, marker_every=marker_every(settings.marker_rate, every, simulation.dt_ns)
            ),
        ),
        warn=node.warn,
    )
    names, shared = names_on_the_wire(
        [topic.name for topic in recorded_topics(run)], node.resolve_topic_name
    )
    run.settings = replace(run.settings, topic_names=names)
    if shared:
        node.warn(
            f'remapping gives one name to several topics; they are recorded under their own: '
            f'{", ".join(sorted(shared)[:SHOWN])}{" …" if len(shared) > SHOWN else ""}'
        )
    note = rate_note(settings.publish_rate, simulation.dt_ns)
    if note is not None:
        node.warn(note)
    return run


def _view_settings(node: SimNode) -> ViewSettings:
    settings = node.settings
    return ViewSettings(
        settings.views,
        arrow_scale=settings.arrow_scale,
        frame_prefix=settings.frame_prefix,
        node_name=node.get_name(),
        body_topics=settings.body_topics,
    )


def _make_gate(node: SimNode, run: Run) -> Gate:
    """Agree on the terms of lock-step; UserError where they do not fit the scene."""
    settings, scene = node.settings, run.simulation.scene
    terms = Terms(
        settings.lockstep_topics,
        lockstep.targets_of(
            settings.lockstep_topics,
            known=topics_of(run.names, namespace=node.get_namespace()),
            namespace=node.get_namespace(),
            scene=scene,
            rules=run.rules,
            remapped=node.resolve_topic_name,
        ),
        lockstep.period_of(
            settings.lockstep_period,
            publish_every=run.settings.publish_every,
            dt_ns=run.simulation.dt_ns,
        ),
        stamped=settings.lockstep_stamps,
        timeout=round(settings.lockstep_timeout * 1e9),
    )
    return Gate(terms, Inbox(run.rules))


def _make_turns(node: SimNode, run: Run, gate: Gate) -> LockstepTurns:
    return LockstepTurns(
        gate,
        dt_ns=run.simulation.dt_ns,
        publish_every=run.settings.publish_every,
        door=node.open_door(gate),
        links=node.links,
        silence=node.silence,
        publish=node.publish,
        warn=node.warn,
    )


def _make_loop(
    node: SimNode, run: Run, inbox: Inbox, bags: Bags, turns: LockstepTurns | None
) -> RunLoop:
    settings = node.settings
    return RunLoop(
        run,
        inbox=inbox,
        bags=bags,
        publish=node.publish,
        report=node.report,
        report_period=settings.diagnostics_period,
        factor=settings.real_time_factor,
        stop_time=settings.stop_time,
        paused=settings.start_paused,
        lockstep=turns,
        say=node.say,
    )


def _ready_line(node: SimNode, run: Run, bags: Bags) -> str:
    simulation = run.simulation
    bodies = [body.name for body in simulation.scene.bodies]
    names = ', '.join(bodies[:MOST_SHOWN])
    if len(bodies) > MOST_SHOWN:
        names += f', … {len(bodies)} bodies'
    prefix = node.get_namespace().rstrip('/')
    recording = f'recording to {bags.path}' if bags.is_open else 'not recording'
    return (
        f'ready: {simulation.scene.name} ({names}), {simulation.integrator.name}, '
        f'dt {simulation.dt:g} s, topics {prefix}/<body>/…, {recording}'
        f'{", paused" if node.settings.start_paused else ""}{_waiting_for(node.settings)}'
    )


def _waiting_for(settings: Settings) -> str:
    return f', in lock-step with {lockstep.shown(settings.lockstep_topics)}' * (
        settings.step_mode == 'lockstep'
    )


def _spin(node: SimNode, loop: RunLoop, context: Context, more: Standard | None) -> Ending:
    """Let the loop run in its thread, and the executor here, until it has ended."""
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    thread = threading.Thread(target=loop.run, name='run_loop')
    sys.setswitchinterval(SWITCH_INTERVAL)
    gc.collect()
    gc.freeze()  # what is loaded by now stays: no long collection in the middle of a run
    node.listener.start()
    thread.start()
    try:
        while loop.ending is None:
            executor.spin_once(timeout_sec=SPIN)
        node.settle(executor)
        if more is not None:
            more.settle(executor)
    finally:
        loop.stop = True
        thread.join()
        node.listener.stop()
        loop.tell_the_end()
        executor.shutdown()
    assert loop.ending is not None
    return loop.ending
