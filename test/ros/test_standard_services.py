# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The services of simulation_interfaces, called by another process as its clients do.
"""

import math
from functools import cached_property

import pytest
from geometry_msgs.msg import Point, Quaternion, Vector3, Vector3Stamped
from rcl_interfaces.srv import SetParameters
from rclpy.action import ActionClient
from rclpy.parameter import Parameter

from rigid_body_sim.recording.bag_reader import Bag

from ..message_packages import importable
from .conftest import ROOT, Peer, start
from .conftest import force as force_message

OK, NOT_FOUND, FAILED, UNSUPPORTED = 1, 2, 4, 0
ALREADY, INVALID_POSE = 101, 101


@pytest.fixture(scope='module')
def installed():
    with importable('simulation_interfaces'):
        yield


class Client(Peer):
    """
    Calls services by the name of their type.
    """

    def ask(self, kind, **fields):
        from simulation_interfaces import srv

        name = ''.join(f'_{c.lower()}' if c.isupper() else c for c in kind).lstrip('_')
        service = getattr(srv, kind)
        return self.call(service, f'rigid_body_sim/{name}', service.Request(**fields))

    def ready(self, kind, name):
        """
        A client of a service that has answered before: calls may be made without waiting.
        """
        self.call(kind, f'rigid_body_sim/{name}', kind.Request())
        return self._clients[kind, f'rigid_body_sim/{name}']

    @cached_property
    def action(self):
        from simulation_interfaces.action import SimulateSteps

        client = ActionClient(self.node, SimulateSteps, self.full('rigid_body_sim/simulate_steps'))
        self.until(client.server_is_ready, 'the action')
        self.be_known()  # or the first feedback is lost
        return client

    def close(self):
        if 'action' in self.__dict__:
            self.action.destroy()  # before its node, which does not know of it
        super().close()

    def state_of(self, entity):
        response = self.ask('GetEntityState', entity=entity)
        assert response.result.result == OK, response.result.error_message
        return response.state

    def ticks(self):
        stamp = self.state_of('box').header.stamp
        return round((stamp.sec + stamp.nanosec * 1e-9) * 1000)

    def set(self, number):
        from simulation_interfaces.msg import SimulationState

        return self.ask('SetSimulationState', state=SimulationState(state=number)).result

    def is_in(self):
        return self.ask('GetSimulationState').state.state


@pytest.fixture(scope='module')
def served(installed, tmp_path_factory):
    """
    A node that is paused, and records; its client.
    """
    folder = tmp_path_factory.mktemp('standard')
    node = start(folder, '/std', start_paused='true', record='true', record_path='bag')
    client = Client('/std')
    client.node_process = node
    yield client
    client.close()
    assert node.stop() == 0, node.said
    assert 'Traceback' not in node.said
    node.close()


def result_of(response):
    return response.result.result


def test_only_what_works_is_advertised(served):
    from simulation_interfaces.msg import SimulatorFeatures as Known

    told = served.ask('GetSimulatorFeatures').features
    names = {
        name for name in dir(Known) if name.isupper() and getattr(Known, name) in told.features
    }
    assert names == {
        'NAMED_POSES',
        'ENTITY_TAGS',
        'ENTITY_BOUNDS',
        'ENTITY_BOUNDS_BOX',
        'ENTITY_CATEGORIES',
        'ENTITY_STATE_GETTING',
        'ENTITY_STATE_SETTING',
        'ENTITY_INFO_GETTING',
        'SIMULATION_RESET',
        'SIMULATION_RESET_STATE',
        'SIMULATION_STATE_GETTING',
        'SIMULATION_STATE_SETTING',
        'SIMULATION_STATE_PAUSE',
        'STEP_SIMULATION_SINGLE',
        'STEP_SIMULATION_MULTIPLE',
        'STEP_SIMULATION_ACTION',
    }


def test_steps_are_ticks_and_need_a_pause(served):
    assert served.is_in() == 2
    begin = served.ticks()
    done = served.ask('StepSimulation', steps=250)
    assert result_of(done) == OK
    assert '250 of 250 steps' in done.result.error_message
    assert result_of(served.ask('StepSimulation')) == OK  # one, by default
    assert result_of(served.ask('StepSimulation', steps=0)) == OK
    assert served.ticks() == begin + 251
    assert served.set(2).result == ALREADY
    assert served.set(1).result == OK
    assert served.is_in() == 1
    assert served.set(1).result == ALREADY
    refused = served.ask('StepSimulation', steps=1)
    assert result_of(refused) == FAILED
    assert 'not paused' in refused.result.error_message
    assert served.set(2).result == OK
    for state in (0, 4, 5, 77):
        assert served.set(state).result == UNSUPPORTED


def test_a_state_that_is_set_holds_and_replays_bit_for_bit(served, run_verb):
    from simulation_interfaces.msg import EntityState

    half = math.sqrt(0.5)
    wanted = EntityState()
    wanted.header.frame_id = 'world'
    wanted.pose.position = Point(x=1.0, y=2.0, z=3.0)
    wanted.pose.orientation = Quaternion(x=half, w=half)
    wanted.twist.linear = Vector3(x=0.5)
    wanted.twist.angular = Vector3(z=0.25)
    assert result_of(served.ask('SetEntityState', entity='box', state=wanted)) == OK
    now = served.state_of('box')  # before the next tick: it holds already for who asks
    assert now.pose.position == wanted.pose.position
    assert now.twist == wanted.twist
    assert served.ask('StepSimulation', steps=100).result.result == OK
    later = served.state_of('box')
    assert later.pose.position.x == pytest.approx(1.05, abs=1e-12)  # truncation: none, a free body
    assert later.twist.linear.x == 0.5
    served.sender('box/force', Vector3Stamped).publish(force_message(4, 0, 0))
    served.until(
        lambda: (
            result_of(served.ask('StepSimulation')) == OK
            and served.state_of('box').acceleration.linear.x == 2.0
        ),  # 4 N on 2 kg
        'the force',
    )
    for entity, change, code in (
        ('box', {'orientation': Quaternion(w=0.0)}, INVALID_POSE),
        ('box', {'position': Point(x=math.nan)}, INVALID_POSE),
        ('nobody', {}, NOT_FOUND),
        ('plate', {}, FAILED),
    ):
        state = EntityState()
        for name, value in change.items():
            setattr(state.pose, name, value)
        response = served.ask('SetEntityState', entity=entity, state=state)
        assert result_of(response) == code, response
        assert response.result.error_message
    bad = EntityState()
    bad.twist.linear.x = math.inf
    assert result_of(served.ask('SetEntityState', entity='box', state=bad)) == FAILED
    bad = EntityState()
    bad.header.frame_id = 'stone'
    assert result_of(served.ask('SetEntityState', entity='box', state=bad)) == FAILED
    closed = served.switch('record', False)
    assert closed.success
    path = served.node_process.folder / 'bag'
    assert [m.topic for m in Bag(path).messages(['/std/box/set_state'])] == ['/std/box/set_state']
    assert run_verb('replay', path).returncode == 0


def test_entities_are_found_by_name_category_tag_and_place(served):
    from simulation_interfaces.msg import Bounds, EntityCategory, EntityFilters, TagsFilter

    assert served.ask('ResetSimulation', scope=2).result.result == OK

    def found(**filters):
        response = served.ask('GetEntities', filters=EntityFilters(**filters))
        assert result_of(response) == OK, response.result.error_message
        return list(response.entities)

    def refused(**filters):
        response = served.ask('GetEntities', filters=EntityFilters(**filters))
        assert response.result.error_message
        return result_of(response)

    def sphere(x, radius):
        return Bounds(type=3, points=[Vector3(x=float(x)), Vector3(x=float(radius))])

    assert found() == ['box', 'stone', 'plate']
    assert found(filter='[[:alpha:]]{3}') == ['box']
    assert found(filter='(st|pl).*') == ['stone', 'plate']
    assert found(filter='ston') == []
    assert found(categories=[EntityCategory(category=5)]) == ['plate']
    assert found(categories=[EntityCategory(category=2)]) == []
    assert found(tags=TagsFilter(tags=['box', 'particle'])) == ['box', 'stone']
    assert found(tags=TagsFilter(tags=['box', 'rigid'], filter_mode=1)) == ['box']
    # the box is 0.4 long along y, 0.2 along x: it was turned
    assert found(bounds=sphere(-0.5, 0.41)) == ['box']
    assert found(bounds=sphere(-0.5, 0.39)) == []
    assert found(bounds=sphere(2, 1)) == ['stone']
    corners = [Vector3(x=5.0, y=5.0, z=-4.89), Vector3(x=-5.0, y=-5.0, z=-4.95)]
    assert found(bounds=Bounds(type=1, points=corners)) == ['plate']
    assert refused(filter='(') == FAILED
    assert refused(tags=TagsFilter(filter_mode=9)) == FAILED
    assert refused(bounds=Bounds(type=2, points=corners)) == UNSUPPORTED
    assert refused(bounds=Bounds(type=3)) == FAILED
    assert refused(bounds=sphere(0, math.nan)) == FAILED

    everything = served.ask('GetEntitiesStates', filters=EntityFilters(filter='stone|plate'))
    assert list(everything.entities) == ['stone', 'plate']
    assert [s.pose.position.x for s in everything.states] == [1.0, 0.0]
    assert {s.header.frame_id for s in everything.states} == {'world'}

    info = served.ask('GetEntityInfo', entity='box').info
    assert (info.category.category, list(info.tags)) == (4, ['rigid', 'box'])
    assert '2 kg' in info.description
    high, low = served.ask('GetEntityBounds', entity='box').bounds.points
    assert (high.x, high.y, high.z) == (0.2, 0.1, 0.05)
    assert (low.x, low.y, low.z) == (-0.2, -0.1, -0.05)
    for kind in ('GetEntityInfo', 'GetEntityState', 'GetEntityBounds'):
        missing = served.ask(kind, entity='nobody')
        assert result_of(missing) == NOT_FOUND
        assert 'box, stone, plate' in missing.result.error_message
    poses = {pose.name: pose.pose for pose in served.ask('GetNamedPoses').poses}
    assert poses['stone'].position.x == 1.0
    assert served.ask('GetNamedPoses', tags=TagsFilter(tags=['frame'])).poses == []


def test_a_reset_says_that_time_goes_on(served):
    served.ask('StepSimulation', steps=10)
    before = served.ticks()
    for scope in (0, 1, 4, 255, 3):
        response = served.ask('ResetSimulation', scope=scope)
        assert result_of(response) == UNSUPPORTED
        assert 'time goes on' in response.result.error_message
    assert result_of(served.ask('ResetSimulation', scope=2)) == OK
    assert served.ticks() == before


def act(client, steps, seen):
    """
    Send a goal; return its handle.
    """
    from simulation_interfaces.action import SimulateSteps

    sent = client.action.send_goal_async(
        SimulateSteps.Goal(steps=steps),
        feedback_callback=lambda told: seen.append(
            (told.feedback.completed_steps, told.feedback.remaining_steps)
        ),
    )
    client.until(sent.done, 'an answer to the goal')
    assert sent.result().accepted
    return sent.result()


def ended(client, goal):
    future = goal.get_result_async()
    client.until(future.done, 'the result')
    return future.result().status, future.result().result.result


SUCCEEDED, CANCELED, ABORTED = 4, 5, 6
MANY = 2**63


def test_the_action_tells_each_step_is_cancelled_and_lets_others_in(served):
    seen = []
    begin = served.ticks()
    goal = act(served, 5, seen)
    # before its result: with that, a client of rclpy drops what feedback it has not taken yet
    served.until(lambda: len(seen) == 5, 'feedback')
    assert seen == [(1, 4), (2, 3), (3, 2), (4, 1), (5, 0)]
    status, result = ended(served, goal)
    assert (status, result.result) == (SUCCEEDED, OK)
    assert served.ticks() == begin + 5

    seen.clear()
    goal = act(served, MANY, seen)
    served.until(lambda: seen, 'feedback')
    assert served.is_in() == 1  # it moves
    more = served.ask('StepSimulation', steps=3)
    assert result_of(more) == FAILED
    assert 'still to be done' in more.result.error_message
    assert not served.trigger('step').success
    other, refused = ended(served, act(served, 3, []))
    assert (other, refused.result) == (ABORTED, FAILED)
    cancelled = goal.cancel_goal_async()
    served.until(cancelled.done, 'the cancellation')
    status, result = ended(served, goal)
    assert (status, result.result) == (CANCELED, FAILED)
    assert 'cancelled' in result.error_message
    done = served.ticks()
    assert all(left == MANY - steps for steps, left in seen)
    assert served.is_in() == 2
    assert served.ticks() == done

    goal = act(served, MANY, [])  # a pause ends it too
    assert served.set(2).result == OK
    status, result = ended(served, goal)
    assert (status, result.result) == (ABORTED, FAILED)
    assert 'paused' in result.error_message


def test_an_interrupt_ends_steps_and_tells_their_client(served):  # the last that needs the node
    seen = []
    future = act(served, MANY, seen).get_result_async()
    served.until(lambda: seen, 'feedback')
    assert served.node_process.stop() == 0
    served.until(future.done, 'the result')
    assert future.result().status == ABORTED
    assert 'the run has ended' in future.result().result.result.error_message


def test_the_standard_way_to_quit_ends_the_node(installed, tmp_path):
    node = start(tmp_path, '/quit')
    client = Client('/quit')
    try:
        assert client.set(3).result == OK
        assert node.wait() == 0
        assert 'Traceback' not in node.said
    finally:
        client.close()
        node.close()


def test_no_command_timeout_slips_in_while_a_reset_changes_bags(installed, tmp_path):
    from simulation_interfaces.srv import ResetSimulation

    node = start(tmp_path, '/slip', record='true', record_path='bag')
    client = Client('/slip')
    reset = client.ready(ResetSimulation, 'reset_simulation')
    change = client.ready(SetParameters, 'set_parameters')
    try:
        answers = []
        for turn in range(12):
            done = reset.call_async(ResetSimulation.Request(scope=2))
            while not done.done():
                value = Parameter('command_timeout', value=1.0 + turn).to_parameter_msg()
                asked = change.call_async(SetParameters.Request(parameters=[value]))
                client.until(asked.done, 'an answer')
                answers += asked.result().results
            assert result_of(done.result()) == OK
        assert answers
        assert not [answer for answer in answers if answer.successful]
        assert all('~/record' in answer.reason for answer in answers)
    finally:
        client.close()
        code = node.stop()
        node.close()
    assert code == 0, node.said


def test_lockstep_that_timed_out_is_paused_to_all_and_names_what_is_missing(installed, tmp_path):
    node = start(
        tmp_path,
        '/late',
        step_mode='lockstep',
        lockstep_topics='[box/torque]',
        lockstep_timeout=0.1,
    )
    client = Client('/late')
    try:
        client.until(lambda: 'paused: ' in node.said, 'the time-out')
        assert client.is_in() == 2
        refused = client.ask('StepSimulation', steps=1)
        assert result_of(refused) == FAILED
        for text in (refused.result.error_message, client.trigger('step').message):
            assert 'box/torque' in text
            assert 'not paused' not in text
    finally:
        client.close()
        code = node.stop()
        node.close()
    assert code == 0, node.said


def test_the_page_tells_each_service():
    from rigid_body_sim.ros.standard.offered import SERVICES

    page = (ROOT / 'docs' / 'simulation_interfaces.md').read_text()
    for service in SERVICES:
        assert f'| `~/{service.name}` | {service.type}' in page
        assert service.meaning in page
