# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A node in a process of its own, and a peer in this one that talks to it over DDS.

Nothing here waits for a fixed time: `Peer.until` spins until something holds. Discovery may take
2.5 s on a quiet machine, and a word that got lost on a busy one is said again only after 3 s; what
has not come after five minutes will not come.
"""

import contextlib
import io
import os
import signal
import subprocess
import sys
import threading
import time
from contextlib import contextmanager
from pathlib import Path

import pytest

pytest.importorskip('rclpy')

import rclpy  # noqa: E402
from geometry_msgs.msg import Vector3Stamped, WrenchStamped  # noqa: E402
from rcl_interfaces.srv import ListParameters, SetParameters  # noqa: E402
from rclpy.executors import SingleThreadedExecutor  # noqa: E402
from rclpy.parameter import Parameter  # noqa: E402
from rclpy.qos import QoSProfile  # noqa: E402
from std_srvs.srv import SetBool, Trigger  # noqa: E402

from rigid_body_sim.__main__ import main  # noqa: E402
from rigid_body_sim.recording import cdr  # noqa: E402
from rigid_body_sim.recording.bag_reader import Bag  # noqa: E402
from rigid_body_sim.ros.conversions import MESSAGE_TYPES  # noqa: E402
from rigid_body_sim.testing.domains import DomainLease  # noqa: E402
from rigid_body_sim.testing.surroundings import PROFILE, PROFILE_VARIABLES  # noqa: E402

from .. import inside  # noqa: E402
from ..nursery import Nursery  # noqa: E402
from ..patience import HANGING, PATIENCE  # noqa: E402

ROOT = Path(__file__).parents[2]
DOMAIN = DomainLease().number  # held as long as this process lives
ASK_AGAIN = 5.0  # [s] for an answer that can be lost

# A box turned by 90 degrees about z (its x axis points along y), a point mass, a fixed body.
SCENE = """
version: 1
name: laboratory
dt: 0.001
gravity: [0, 0, 0]
bodies:
  - name: box
    shape: {type: box, size: [0.4, 0.2, 0.1]}
    mass: 2.0
    initial: {position: [0, 0, 0], orientation: [0, 0, 0.7071067811865476, 0.7071067811865476]}
    frames: {nozzle: {position: [0.25, 0, 0]}}
  - name: stone
    shape: {type: particle}
    mass: 0.5
    initial: {position: [1, 0, 0]}
  - name: plate
    shape: {type: sphere, radius: 0.1}
    fixed: true
    initial: {position: [0, 0, -5]}
"""


@contextmanager
def isolation():
    """
    Hear nobody but the processes of this test run.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
        patch.setenv('ROS_DOMAIN_ID', str(DOMAIN))
        patch.setenv('PYTHONPATH', str(ROOT), prepend=os.pathsep)
        if not any(os.environ.get(name) for name in PROFILE_VARIABLES):
            patch.setenv(PROFILE_VARIABLES[0], str(PROFILE))
        # the same bits, and a node starts in two thirds of the time; some tests take it back
        patch.setenv('RIGID_BODY_SIM_COMPILE', '0')
        yield patch


@pytest.fixture(scope='module', autouse=True)
def isolated():
    """
    Be isolated, but no longer than a test of this folder is running.
    """
    with isolation():
        yield


NURSERY = Nursery()


@pytest.fixture(scope='session', autouse=True)
def nursery():
    """
    Where nodes come from; it ends behind the last of them.
    """
    yield
    NURSERY.end()


class Peer:
    """
    Another ROS node, in this process.
    """

    def __init__(self, namespace):
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=DOMAIN)
        self.node = rclpy.create_node(f'peer_{time.monotonic_ns()}', context=self.context)
        self._executor = SingleThreadedExecutor(context=self.context)
        self._executor.add_node(self.node)
        self._clients = {}
        self._subscriptions, self._publishers = [], []
        self.namespace = namespace

    def until(self, holds, what='it', seconds=PATIENCE):
        """
        Spin until `holds()` is true; return what it gave.
        """
        deadline = time.monotonic() + seconds
        while not (value := holds()):
            assert time.monotonic() < deadline, f'{what} did not come within {seconds} s'
            self._executor.spin_once(timeout_sec=0.02)
        return value

    def full(self, name):
        """
        Absolute name below the namespace of the node.
        """
        return name if name.startswith('/') else f'{self.namespace}/{name}'

    def listen(self, name, kind, reliability='reliable'):
        """
        Collect the decoded messages of a topic from now on.
        """
        heard = []
        profile = QoSProfile(
            depth=1000, reliability=rclpy.qos.ReliabilityPolicy[reliability.upper()]
        )
        subscription = self.node.create_subscription(
            MESSAGE_TYPES[kind.TYPE],
            self.full(name),
            lambda data: heard.append(cdr.decode(kind.TYPE, data)),
            profile,
            raw=True,
        )
        self._subscriptions.append(subscription)
        self.until(subscription.get_publisher_count, f'a publisher of {name}')
        self.be_known()
        return heard

    def be_known(self):
        """
        Wait until the node knows of all readers that were made so far, and sends to them.

        It learns of the client below later, in the order in which both were made; so when that
        one has its answer, publishers send to us. It must be a new one: those that are kept were
        there before.
        """
        client = self._client(ListParameters, 'rigid_body_sim/list_parameters')
        while not self._is_answered(client, ListParameters.Request()):
            pass  # the node answered before it knew of the reader of its answer: that one is lost
        self.node.destroy_client(client)

    def sender(self, name, kind, reliability='reliable'):
        """
        Make a publisher; wait until somebody listens.
        """
        profile = QoSProfile(
            depth=1000, reliability=rclpy.qos.ReliabilityPolicy[reliability.upper()]
        )
        publisher = self.node.create_publisher(kind, self.full(name), profile)
        self._publishers.append(publisher)
        if reliability == 'reliable':
            self.until(publisher.get_subscription_count, f'a subscriber of {name}')
        return publisher

    def call(self, kind, name, request):
        """
        Call a service; its client is kept, so that the next call waits for no discovery.

        The first answer would be lost if the node did not know of its reader yet.
        """
        if (kind, name) not in self._clients:
            self._clients[kind, name] = self._client(kind, name)
            if name.startswith('rigid_body_sim/'):
                self.be_known()
        return self._answer(self._clients[kind, name], request)

    def _client(self, kind, name):
        client = self.node.create_client(kind, self.full(name))
        self.until(client.service_is_ready, f'service {name}')
        return client

    def _is_answered(self, client, request):
        """
        Ask what may be asked twice; whether an answer came in time.
        """
        future = client.call_async(request)
        again = time.monotonic() + ASK_AGAIN
        self.until(lambda: future.done() or time.monotonic() > again, 'time')
        return future.done()

    def _answer(self, client, request):
        future = client.call_async(request)
        self.until(future.done, f'answer of {client.srv_name}')
        return future.result()

    def trigger(self, name):
        """
        Call ~/step or ~/reset.
        """
        return self.call(Trigger, f'rigid_body_sim/{name}', Trigger.Request())

    def switch(self, name, on):
        """
        Call ~/pause or ~/record.
        """
        return self.call(SetBool, f'rigid_body_sim/{name}', SetBool.Request(data=on))

    def begin(self, name):
        """
        Call ~/step or ~/reset, which was called before, and wait for nothing: the answer to come.
        """
        return self._clients[Trigger, f'rigid_body_sim/{name}'].call_async(Trigger.Request())

    def set(self, name, value):
        """
        Set a parameter; returns the result.
        """
        parameter = Parameter(name, value=value).to_parameter_msg()
        request = SetParameters.Request(parameters=[parameter])
        return self.call(SetParameters, 'rigid_body_sim/set_parameters', request).results[0]

    def forget(self):
        """
        End what `listen` and `sender` made.

        Those of many tests together would be flooded by a node that runs as fast as it can: with
        24 subscriptions an answer then may take 10 s to come through, with none some hundredths.
        """
        while self._subscriptions:
            self.node.destroy_subscription(self._subscriptions.pop())
        while self._publishers:
            self.node.destroy_publisher(self._publishers.pop())

    def close(self):
        """
        End it.
        """
        self._executor.shutdown()
        self.forget()
        for client in self._clients.values():
            self.node.destroy_client(client)
        self.node.destroy_node()
        self.context.try_shutdown()


class NodeProcess:
    """
    `sim_node` in a process of its own.
    """

    def __init__(self, folder, *, namespace, parameters, more=(), preexec=None):
        self.folder = folder
        self.namespace = namespace
        words = ['sim_node', '--ros-args', '-r', f'__ns:={namespace}']
        words += [
            word for name, value in parameters.items() for word in ('-p', f'{name}:={value}')
        ]
        words += more
        self._lines = []
        self._ended = False
        self._changed = threading.Condition()
        plain = os.environ['RIGID_BODY_SIM_COMPILE'] == '0'
        own = preexec is not None or (Path(folder) / 'rigid_body_sim').exists()
        if plain and not own and NURSERY.takes(os.environ):
            self.process = NURSERY.start(words, folder, os.environ)
        else:
            self.process = subprocess.Popen(
                [sys.executable, '-m', 'rigid_body_sim', *words],
                cwd=folder,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                encoding='utf-8',
                errors='replace',  # a node that is killed may leave half a letter
                preexec_fn=preexec,
            )
        self._reader = threading.Thread(target=self._read, name='reader of the node', daemon=True)
        self._reader.start()

    def _read(self):
        for line in self.process.stdout:
            with self._changed:
                self._lines.append(line)
                self._changed.notify_all()
        with self._changed:
            self._ended = True
            self._changed.notify_all()

    @property
    def said(self):
        """
        What it wrote so far, whole lines.
        """
        return ''.join(self._lines)

    def wait_until_ready(self):
        """
        Wait until it is ready, or has ended.
        """
        self.wait_until_said('ready:')

    def wait_until_said(self, words):
        """
        Wait until it has said something, or has ended.
        """
        with self._changed:
            came = self._changed.wait_for(
                lambda: self._ended or words in self.said, timeout=HANGING
            )
        assert came, f'not {words!r} within {HANGING} s: {self.said}'

    def stop(self, number=signal.SIGINT):
        """
        Send a signal; returns the exit code.
        """
        self.process.send_signal(number)
        return self.wait()

    def wait(self):
        """
        Wait for the end and its last words; returns the exit code.
        """
        code = self.process.wait(timeout=PATIENCE)
        self._reader.join()
        return code

    def close(self):
        """
        Make sure that it is gone.
        """
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait()
        self._reader.join()
        self.process.stdout.close()


def start(folder, namespace, preexec=None, more=(), **parameters):
    """
    Start a node on the scene of this folder; more: further arguments for ROS.
    """
    scene = folder / 'laboratory.yaml'
    scene.write_text(SCENE)
    node = NodeProcess(
        folder,
        namespace=namespace,
        parameters={'scene': scene, **parameters},
        more=more,
        preexec=preexec,
    )
    try:
        node.wait_until_ready()
    except BaseException:
        node.close()
        raise
    return node


@pytest.fixture
def start_node(tmp_path, request):
    """
    Start nodes with given parameters; each gets a namespace of its own.
    """
    started = []

    def make(**parameters):
        namespace = f'/n{time.monotonic_ns()}'
        node = start(tmp_path, namespace, **parameters)
        started.append(node)
        return node

    yield make
    for node in started:
        node.close()


@pytest.fixture
def meet():
    """
    Make peers of nodes.
    """
    peers = []

    def make(node):
        peers.append(Peer(node.namespace))
        return peers[-1]

    yield make
    for peer in peers:
        peer.close()


class Laboratory:
    """
    One node in real time, and its peer, for many tests.
    """

    def __init__(self):
        self._peer = None

    def peer(self, folders):
        """
        Return the peer; whoever asks first starts the node.
        """
        if self._peer is None:
            with isolation() as patch:
                patch.setenv('RIGID_BODY_SIM_COMPILE', '1')
                node = start(
                    folders.mktemp('lab'), '/lab', publish_clock='false', diagnostics_period=0.1
                )
                self._peer = Peer('/lab')
            self._peer.node_process = node
        return self._peer

    def end(self):
        """
        Stop the node, if there is one.
        """
        peer, self._peer = self._peer, None
        if peer is None:
            return
        peer.close()
        code = peer.node_process.stop()
        peer.node_process.close()
        assert code == 0


LABORATORY = Laboratory()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_teardown(nextitem):
    """
    End the node behind the last test that wants it: it would hear and talk on beside all others.
    """
    yield
    if nextitem is None or 'lab' not in nextitem.fixturenames:
        LABORATORY.end()


@pytest.fixture
def lab(tmp_path_factory):
    """
    The peer of the running node, everything at rest again.
    """
    running = LABORATORY.peer(tmp_path_factory)
    assert running.switch('pause', False).success
    assert running.trigger('reset').success
    yield running
    assert running.switch('pause', True).success  # it costs nothing while others are tested
    running.forget()
    for name, value in (('real_time_factor', 1.0), ('command_timeout', 0.2)):
        assert running.set(name, value).successful


def run_here(*words):
    """
    Run a verb in this process on the plain source of its own kernels, as nodes have them in
    `isolation`: to start another and to import all anew takes longer.
    """
    printed, told = io.StringIO(), io.StringIO()
    with pytest.MonkeyPatch.context() as patch:
        inside.run_plain(patch)
        with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(told):
            code = main([*words])
    return subprocess.CompletedProcess(words, code, printed.getvalue(), told.getvalue())


@pytest.fixture
def run_verb(request):
    """
    Run another verb in a process of its own, or, where it meets no ROS, in this one; returns the
    finished process.
    """

    def run(*words):
        if words[0] in ('replay', 'bag'):
            request.getfixturevalue('own_kernels')
            return run_here(*map(str, words))
        command = [sys.executable, '-m', 'rigid_body_sim', *map(str, words)]
        return subprocess.run(
            command, capture_output=True, text=True, timeout=HANGING, check=False
        )

    return run


@pytest.fixture
def commands_in():
    """
    Read the consumed commands of a bag: (topic, tick, log time, bytes), in file order.
    """

    def read(path):
        bag = Bag(path)
        leaves = ('/force', '/torque', '/wrench', '/impulse', '/set_state')
        return list(bag.messages([name for name in bag.topics if name.endswith(leaves)]))

    return read


def force(x, y, z, frame=''):
    """
    Vector3Stamped with a frame.
    """
    message = Vector3Stamped()
    message.header.frame_id = frame
    message.vector.x, message.vector.y, message.vector.z = map(float, (x, y, z))
    return message


def wrench(linear, angular=(0, 0, 0), frame=''):
    """
    WrenchStamped with a frame.
    """
    message = WrenchStamped()
    message.header.frame_id = frame
    message.wrench.force.x, message.wrench.force.y, message.wrench.force.z = map(float, linear)
    message.wrench.torque.x, message.wrench.torque.y, message.wrench.torque.z = map(float, angular)
    return message


@pytest.fixture
def messages():
    """
    Makers of command messages.
    """
    return type('Messages', (), {'force': staticmethod(force), 'wrench': staticmethod(wrench)})
