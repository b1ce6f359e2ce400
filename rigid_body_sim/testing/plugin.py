# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The plugin of pytest: the fixture `simulation`, and what is told of tests that failed.

Every pytest of an environment loads it, also an old one, so that only pytest is imported before a
test asks for the fixture.
"""

from __future__ import annotations

import pytest

FAILED, SIMULATIONS = 'rigid_body_sim_failed', 'rigid_body_sim_simulations'  # kept at a test
KEPT = 'rigid_body_sim_replay'  # name of the property of a report that holds a line
TITLE = 'bags of failed tests, and how each is replayed'


@pytest.fixture
def simulation(request, tmp_path_factory):
    """
    Start the node for a scene: simulation(scene, *, lockstep=(), **parameters).

    scene      : name of a shipped scene, path, or mapping with the keys of a scene file
    lockstep   : command topics that a controller of the test answers, such as 'satellite/torque'
    parameters : of the node
    returns    : a client of it, see rigid_body_sim.testing.LiveSimulation

    When the test is over the node is ended by SIGINT and must exit with 0. When the test fails,
    its bags are kept in <rootdir>/failed_bags/<test>, and the summary says how to replay them.
    """
    from rigid_body_sim.testing.simulations import Simulations

    simulations = Simulations(tmp_path_factory.mktemp('simulation'))
    setattr(request.node, SIMULATIONS, simulations)
    try:
        yield simulations.start
    finally:
        failed = getattr(request.node, FAILED, False)
        problems = simulations.end()
        if failed or problems:
            for line in simulations.keep(request.config.rootpath, _name(request.node)):
                request.node.user_properties.append((KEPT, line))
        else:
            simulations.discard()
    if problems and not failed:
        pytest.fail('\n'.join(problems), pytrace=False)


def _name(item):
    """
    Return the name of a test, with its file where another test of the session is called alike.
    """
    alike = [one for one in item.session.items if one.name == item.name]
    return item.name if len(alike) < 2 else item.nodeid


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item, call):
    """
    Note that a test has failed, before its fixtures end, and show what the nodes said last.
    """
    report = (yield).get_result()
    if report.failed:
        setattr(item, FAILED, True)
        simulations = getattr(item, SIMULATIONS, None)
        if simulations is not None:
            report.sections += simulations.sections()


def pytest_terminal_summary(terminalreporter):
    """
    Tell how the bags of failed tests are replayed, also those of other workers.
    """
    lines = {
        line: None
        for reports in terminalreporter.stats.values()
        for report in reports
        for name, line in getattr(report, 'user_properties', ())
        if name == KEPT
    }
    if lines:
        terminalreporter.section(TITLE)
        for line in lines:
            terminalreporter.write_line(line)
