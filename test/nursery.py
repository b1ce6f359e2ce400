# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Nodes as children of a process that has imported what a node needs: that takes four fifths of the
time in which one starts, and is the same for all. What it does from then on is what it does as
`python -m rigid_body_sim sim_node`.

    python test/nursery.py FD    is such a process; it waits on the socket FD, which is inherited
"""

import contextlib
import importlib
import json
import os
import runpy
import select
import signal
import socket
import subprocess
import sys
import warnings

MOST = 200_000  # [bytes] of words, folder and environment of a node
# of the environment, what is read behind all imports
LATER = {'PYTEST_CURRENT_TEST', 'ROS_DOMAIN_ID', 'ROS_AUTOMATIC_DISCOVERY_RANGE'}


class Nursery:
    """
    Such a process, begun with the first node of an environment, and for nodes of that one alone.
    """

    def __init__(self):
        self._door = self._process = self._environment = None

    def takes(self, environment):
        """
        Whether a node of such an environment can be one of its children.
        """
        early = {k: v for k, v in environment.items() if k not in LATER}
        if self._door is None:
            self._environment = early
        return early == self._environment

    def start(self, words, folder, environment):
        """
        Begin a node with such words in a folder; like a `subprocess.Popen`.
        """
        if self._door is None:
            self._door, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
            self._process = subprocess.Popen(
                [sys.executable, __file__, str(theirs.fileno())],
                env=environment, pass_fds=[theirs.fileno()],
                stdout=subprocess.PIPE, stderr=subprocess.STDOUT,  # what nodes take for pipes, are
            )  # fmt: skip
            theirs.close()
        request = json.dumps([list(map(str, words)), str(folder), dict(environment)]).encode()
        assert len(request) < MOST
        output, of_node = os.pipe()
        status, of_nursery = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        socket.send_fds(self._door, [request], [of_node, of_nursery.fileno()])
        os.close(of_node)
        of_nursery.close()
        return Child(status, output)

    def end(self):
        """
        Let it end; its nodes have.
        """
        if self._door is not None:
            self._door.close()
            self._process.communicate()
            self._door = None


class Child:
    """
    A node of a nursery, with what tests ask of a `subprocess.Popen`.
    """

    def __init__(self, status, output):
        self._status = status
        self.stdout = open(output, encoding='utf-8', errors='replace')  # noqa: PTH123, SIM115
        self.returncode = None
        self.pid = int(self._told(None))

    def _told(self, timeout):
        self._status.settimeout(timeout)
        said = self._status.recv(100)
        assert said, 'the nursery of nodes has ended'
        return said

    def wait(self, timeout=None):
        """
        Wait for the end; give the exit code.
        """
        if self.returncode is None:
            try:
                self.returncode = int(self._told(timeout))
            except (TimeoutError, BlockingIOError):
                raise subprocess.TimeoutExpired('sim_node', timeout) from None
            self._status.close()
        return self.returncode

    def poll(self):
        """
        The exit code, or None while it runs.
        """
        try:
            return self.wait(0.0)
        except subprocess.TimeoutExpired:
            return None

    def send_signal(self, number):
        """
        Send a signal, unless it has ended.
        """
        if self.poll() is None:
            os.kill(self.pid, number)

    def kill(self):
        """
        End it at once.
        """
        self.send_signal(signal.SIGKILL)


def _import_all():
    """
    Import what a node needs, but the module that it runs.
    """
    for module in ('verbs.sim_node', 'ros.session'):
        importlib.import_module(f'rigid_body_sim.{module}')
    types = importlib.import_module('rigid_body_sim.ros.conversions').MESSAGE_TYPES
    for kind in types.values():
        type(kind).__import_type_support__()


def _serve(door):
    """
    Begin nodes and tell how they ended, until nobody asks any more; in each node give its words,
    folder, environment and output.
    """
    waiting, poll = {}, select.poll()
    poll.register(door, select.POLLIN)
    while True:
        for ready, _ in poll.poll():
            if ready in waiting:
                child, status = waiting.pop(ready)
                poll.unregister(ready)
                os.close(ready)
                code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
                with contextlib.suppress(OSError):  # nobody may listen any more
                    status.send(str(code).encode())
                status.close()
                continue
            request, handles, *_ = socket.recv_fds(door, MOST, 2)
            if not request:
                return None
            with warnings.catch_warnings():
                warnings.simplefilter('ignore')  # threads of numpy rest
                child = os.fork()
            if child == 0:
                for handle in [door.fileno(), handles[1], *waiting]:
                    os.close(handle)
                for _child, status in waiting.values():
                    status.close()
                door.detach()
                return *json.loads(request), handles[0]
            os.close(handles[0])
            status = socket.socket(fileno=handles[1])
            status.send(str(child).encode())
            handle = os.pidfd_open(child)
            waiting[handle] = child, status
            poll.register(handle, select.POLLIN)


def _main():
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for who asks
    del sys.path[0]  # a node has its folder there
    _import_all()
    asked = _serve(socket.socket(fileno=int(sys.argv[1])))
    if asked is None:
        return
    words, folder, environment, output = asked
    signal.signal(signal.SIGINT, signal.default_int_handler)
    for stream in (1, 2):
        os.dup2(output, stream)
    os.close(output)
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    sys.path.insert(0, folder)  # as of `python -m`
    sys.argv = ['rigid_body_sim', *words]
    runpy.run_module('rigid_body_sim', run_name='__main__', alter_sys=True)


if __name__ == '__main__':
    _main()
