# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What holds for the whole suite: no property fails because the machine is slow, what compiles the
same kernels runs in one worker, and no worker keeps what compiling takes; and a browser for the
tests of pages.
"""

import gc
from functools import cache
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

from rigid_body_sim.physics.compile.images import numba_is_set

from . import chromium, inside

# a first example imports or compiles what it needs, beside whatever else the machine does
settings.register_profile('suite', deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile('suite')

HERE = Path(__file__).parent
FIRST = 'integrators/test_compiled_is_plain.py'  # its first test takes longest
# who compiles or waits most comes first, but what shares kernels with FIRST or with contact behind
# them; files that take long before those that fill up the end
ORDER = (
    'contact, first', 'ros', 'laws', 'stability', 'integrators', 'contact, impacts',
    'contact, forces', 'contact, other kernels', 'contact', 'testing', 'sweeps', 'scene', 'readme',
    'packaging', 'run',
)  # fmt: skip
# files of contact with kernels of their own, made of the same parts as those of the first, which
# all others find
ROOMS_OF_CONTACT = {
    'contact, first': ('bounce_and_impact',),
    'contact, impacts': ('flat_blows', 'impact', 'ticks_cut'),
    'contact, forces': (
        'cut_ticks', 'far_away', 'flowing_mass', 'forces_beside', 'gains_beside',
        'pivots_that_touch', 'prescribed_motion',
    ),
    'contact, other kernels': ('pairs_', 'same_bits', 'sleeping'),
}  # fmt: skip
# whose files share a kernel, so that no two workers wait for it, or a node: while one worker waits
# for it, the others compute
TOGETHER = {'contact, first', 'contact, impacts', 'contact, forces', 'ros'}
APART = {'stability'}  # folders whose tests compile little and may take long


@cache
def room_of(path):
    """
    The folder of a file of tests; of contact: which kernels it has.
    """
    name = path.stem.removeprefix('test_')
    if path.parent.name == 'contact':
        for room, begins in ROOMS_OF_CONTACT.items():
            if name.startswith(begins):
                return room
    return path.parent.name


class BegunElsewhere(pytest.Dir):
    """
    A folder of which each worker reads other files first: to write the asserts of all modules anew
    takes as long as to import them, and what one worker has written is there for the others.
    """

    def collect(self):
        worker, files = self.config.workerinput, list(super().collect())
        number = int(worker['workerid'].removeprefix('gw'))
        first = len(files) * number // worker['workercount']
        return files[first:] + files[:first]


def pytest_collect_directory(path, parent):
    """
    Share what it takes to read the tests among workers.
    """
    if hasattr(parent.config, 'workerinput'):
        return BegunElsewhere.from_parent(parent, path=path)
    return None


def pytest_collection_modifyitems(items):
    """
    Begin with what takes longest; those that share a node one after the other, before others.
    """

    def rank(item):
        room = room_of(item.path)
        later = ORDER.index(room) if room in ORDER else len(ORDER)
        later = -1 if item.path == HERE / FIRST else later
        return later, 'lab' not in item.fixturenames, str(item.path)

    items.sort(key=rank)


def pytest_sessionstart():
    """
    Look for no garbage while some thousand tests are collected.
    """
    gc.disable()


def pytest_collection_finish():
    """
    Look for garbage, but not in what was collected.
    """
    gc.freeze()
    gc.enable()


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """
    Give each worker whole files, in their order; some as one.
    """
    from xdist.scheduler import LoadScopeScheduling

    class ByFile(LoadScopeScheduling):
        def _split_scope(self, nodeid):
            file = nodeid.partition('::')[0]
            room = room_of(Path(file))
            if room in APART:
                return nodeid
            return room if room in TOGETHER else file

    config.option.loadscopereorder = False
    return ByFile(config, log)


@pytest.fixture(scope='session', autouse=True)
def compile_apart():
    """
    Compile in children.
    """
    with pytest.MonkeyPatch.context() as patch:
        inside.compile_apart(patch)
        yield


@pytest.fixture(scope='session', autouse=True)
def shared_kernels():
    """
    Let all scenes share a few kernels; `undo()` gives each its own, for one test.
    """
    with pytest.MonkeyPatch.context() as patch:
        inside.share_kernels(patch)
        yield patch


@pytest.fixture
def own_kernels(shared_kernels):
    """
    Make of a scene what it has where nothing is shared: to look at, for stepping would compile.
    """
    shared_kernels.undo()
    yield
    inside.share_kernels(shared_kernels)


@pytest.fixture
def plain_source(request):
    """
    Run kernels as they are written, for a test of so few ticks that to compile takes longer; not
    in the long form, nor where numba is set (`make test-bounds`).
    """
    with pytest.MonkeyPatch.context() as patch:
        if request.node.get_closest_marker('long') is None and not numba_is_set():
            inside.run_plain(patch)
        yield


@pytest.fixture(scope='module')
def tab(tmp_path_factory):
    """
    A tab of a headless Chromium, one for each module; where there is none, the test is skipped.
    """
    if chromium.find() is None:
        pytest.skip('no Chromium here: apt-get install chromium, and the pages are tested too')
    with chromium.page(tmp_path_factory.mktemp('browser')) as tab:
        tab.scale = 0.25  # a processor draws: a sixteenth of the pixels, the same layout
        yield tab


@pytest.fixture
def verb(capsys):
    """
    Call a verb in this process; give exit code, standard output and standard error.
    """
    from rigid_body_sim.__main__ import main

    def call(*words):
        code = main([str(word) for word in words])
        captured = capsys.readouterr()
        return code, captured.out, captured.err

    return call
