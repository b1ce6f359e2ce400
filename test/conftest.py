# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What holds for the whole suite: no property fails because the machine is slow, and what compiles
the same kernels runs in one worker; and a browser for the tests of pages.
"""

from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

from . import chromium

# a first example imports or compiles what it needs, beside whatever else the machine does
settings.register_profile('suite', deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile('suite')

HERE = Path(__file__).parent
FIRST = 'integrators/test_compiled_is_plain.py'  # its first test takes longest
TOGETHER = {
    'contact'
}  # folders whose files share kernels, so that no two workers compile the same
APART = {'stability'}  # folders whose tests compile little and may take long


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """
    Group the tests for workers by file, some by folder; what takes longest begins.
    """
    for item in items:
        file = item.path.relative_to(HERE)
        group = file.parts[0] if file.parts[0] in TOGETHER else str(file)
        if file.parts[0] not in APART:
            item.add_marker(pytest.mark.xdist_group(group))
    items.sort(key=lambda item: item.path != HERE / FIRST)


@pytest.fixture(scope='module')
def tab(tmp_path_factory):
    """
    A tab of a headless Chromium, one for each module; where there is none, the test is skipped.
    """
    if chromium.find() is None:
        pytest.skip('no Chromium here: apt-get install chromium, and the pages are tested too')
    with chromium.page(tmp_path_factory.mktemp('browser')) as tab:
        yield tab
