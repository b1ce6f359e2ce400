# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What holds for the whole suite: no property fails because the machine is slow, what compiles the
same kernels runs in one worker, and no worker keeps what compiling takes; and a browser for the
tests of pages.
"""

from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

from . import chromium, inside

# a first example imports or compiles what it needs, beside whatever else the machine does
settings.register_profile('suite', deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile('suite')

HERE = Path(__file__).parent
FIRST = 'integrators/test_compiled_is_plain.py'  # its first test takes longest
TOGETHER = {
    'contact'
}  # folders whose files share kernels, so that no two workers compile the same
APART = {'stability'}  # folders whose tests compile little and may take long


def pytest_collection_modifyitems(items):
    """
    Begin with what takes longest.
    """
    items.sort(key=lambda item: item.path != HERE / FIRST)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """
    Give each worker whole files, in their order; some folders as one.
    """
    from xdist.scheduler import LoadScopeScheduling

    class ByFile(LoadScopeScheduling):
        def _split_scope(self, nodeid):
            _, folder, *_ = path = nodeid.partition('::')[0].split('/')
            if folder in APART:
                return nodeid
            return folder if folder in TOGETHER else '/'.join(path)

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
    Let all scenes of contact share a few kernels; `undo()` gives each its own, for one test.
    """
    with pytest.MonkeyPatch.context() as patch:
        inside.share_kernels(patch)
        yield patch


@pytest.fixture
def own_kernels(shared_kernels):
    """
    Give each scene that a test makes from now on its own kernel.
    """
    shared_kernels.undo()
    yield
    inside.share_kernels(shared_kernels)


@pytest.fixture(scope='module')
def tab(tmp_path_factory):
    """
    A tab of a headless Chromium, one for each module; where there is none, the test is skipped.
    """
    if chromium.find() is None:
        pytest.skip('no Chromium here: apt-get install chromium, and the pages are tested too')
    with chromium.page(tmp_path_factory.mktemp('browser')) as tab:
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
