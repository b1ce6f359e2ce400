# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What holds for the whole suite: no property fails because the machine is slow; and a browser for
the tests of pages.
"""

import pytest
from hypothesis import HealthCheck, settings

from . import chromium

# a first example imports or compiles what it needs, beside whatever else the machine does
settings.register_profile('suite', deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile('suite')


@pytest.fixture(scope='module')
def tab(tmp_path_factory):
    """
    A tab of a headless Chromium, one for each module; where there is none, the test is skipped.
    """
    if chromium.find() is None:
        pytest.skip('no Chromium here: apt-get install chromium, and the pages are tested too')
    with chromium.page(tmp_path_factory.mktemp('browser')) as tab:
        yield tab
