# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Who else is in the domain that this node cannot live beside: a second maker of time, a second node
of its name. Both go unnoticed otherwise: whoever listens sees time jump back and forth, and a
service call reaches one of the two.
"""

from __future__ import annotations

from rclpy.node import Node

from rigid_body_sim.ros.lockstep import shown

LEASE = 20  # [s] that Fast DDS keeps a killed process on the graph
_UNKNOWN = '_UNKNOWN_'  # in names that the middleware has not heard yet


class Neighbours:
    """
    Looks at the graph of a node; a look takes some 0.2 ms.

    clock    : topic on which the node publishes time, resolved; empty: it does not
    warnings : what the last look found
    """

    def __init__(self, node: Node, *, clock: str) -> None:
        self._node = node
        self._clock = clock
        self._named = node.get_name(), node.get_namespace()
        self.warnings: tuple[str, ...] = ()

    def look(self) -> list[str]:
        """Look again; return what was not there at the last look."""
        before = self.warnings
        self.warnings = (*self._of_one_name(), *self._other_clocks())
        return [warning for warning in self.warnings if warning not in before]

    def _of_one_name(self) -> list[str]:
        count = self._node.get_node_names_and_namespaces().count(self._named)
        if count < 2:
            return []
        return [
            f'{_named(count - 1, "node")} named {self._node.get_fully_qualified_name()} too: '
            'topics, services and parameters of both have the same names; start with another '
            f'namespace, -r __ns:=/NAME (one that was killed stays known for {LEASE} s)'
        ]

    def _other_clocks(self) -> list[str]:
        if not self._clock:
            return []
        found = self._node.get_publishers_info_by_topic(self._clock)
        makers = [(info.node_name, info.node_namespace) for info in found]
        if self._named in makers:
            makers.remove(self._named)
        names = sorted(
            {
                f'{space.rstrip("/")}/{name}'
                for name, space in makers
                if _UNKNOWN not in name + space
            }
        )
        if not names:
            return []
        return [
            f'{self._clock} is published by {shown(names)} too: time jumps for whoever '
            'listens; start all but one with publish_clock:=false, and of a bag play only what is '
            'wanted: ros2 bag play BAG --topics /<body>/wrench (one that was killed stays known '
            f'for {LEASE} s)'
        ]


def _named(count: int, noun: str) -> str:
    return f'another {noun} is' if count == 1 else f'{count} other {noun}s are'
