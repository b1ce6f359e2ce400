# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A request for all parameters, as `ros2 param dump` and GUI panels make it, is answered whole."""

from pathlib import Path

import pytest

pytest.importorskip('rclpy')

import rclpy
from rcl_interfaces.msg import ParameterType
from rcl_interfaces.srv import DescribeParameters, GetParameters, ListParameters
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter

from rigid_body_sim.errors import UserError
from rigid_body_sim.ros.node import SimNode
from rigid_body_sim.ros.parameters import PARAMETERS

from ..patience import PATIENCE

ROOT = Path(__file__).parents[2]
LISTS = [entry.name for entry in PARAMETERS if entry.default == ()]


class Asked:
    """The parameter services of a node in this process, asked over DDS."""

    def __init__(self, words):
        self.context = rclpy.Context()
        rclpy.init(args=['--ros-args', *words], context=self.context)
        try:
            self.node = SimNode(self.context)
        except BaseException:
            self.context.try_shutdown()
            raise
        self.peer = rclpy.create_node('asks', context=self.context, use_global_arguments=False)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.executor.add_node(self.peer)

    def call(self, kind, name, request):
        client = self.peer.create_client(kind, f'{self.node.get_fully_qualified_name()}/{name}')
        assert client.wait_for_service(PATIENCE)
        future = client.call_async(request)
        self.executor.spin_until_future_complete(future, PATIENCE)
        self.peer.destroy_client(client)
        return future.result()

    def close(self):
        self.executor.shutdown()
        self.peer.destroy_node()
        self.node.destroy_node()
        self.context.try_shutdown()


@pytest.mark.parametrize(
    'words',
    [
        ['-r', '__ns:=/plain'],
        [word for name in LISTS for word in ('-p', f'{name}:=[]')],
        ['--params-file', str(ROOT / 'config' / 'sim_node.yaml')],
    ],
    ids=['defaults', 'empty lists given', 'parameter file'],
)
def test_a_request_for_all_parameters_gives_a_value_for_each(words):
    asked = Asked(words)
    try:
        listed = asked.call(ListParameters, 'list_parameters', ListParameters.Request())
        names = listed.result.names
        assert {entry.name for entry in PARAMETERS} < set(names)
        request = GetParameters.Request(names=names)
        values = asked.call(GetParameters, 'get_parameters', request).values
        assert len(values) == len(names)
        assert all(value.type != ParameterType.PARAMETER_NOT_SET for value in values)
        request = DescribeParameters.Request(names=names)
        described = asked.call(DescribeParameters, 'describe_parameters', request).descriptors
        assert [d.type for d in described] == [value.type for value in values]
        live = {entry.name for entry in PARAMETERS if entry.live}
        for name in LISTS:
            assert values[names.index(name)].type == ParameterType.PARAMETER_STRING_ARRAY
            new = Parameter(name, Parameter.Type.STRING_ARRAY, ['a'])
            (result,) = asked.node.set_parameters([new])
            assert result.successful == (name in live), result.reason
    finally:
        asked.close()


def test_a_list_of_another_type_is_refused():
    with pytest.raises(UserError, match=f'{LISTS[0]}: got .*allowed: a list of texts'):
        Asked(['-p', f'{LISTS[0]}:=[1, 2]'])
