# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Quality of service that the user gives for a topic, as every ROS node takes it:

    qos_overrides.<resolved topic>.publisher.<policy>       of what the node publishes
    qos_overrides.<resolved topic>.subscription.<policy>    of what it takes

Only what was given becomes a parameter: three for each of 3000 publishers would fill every list.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial

from rcl_interfaces.msg import SetParametersResult
from rclpy.qos import QoSPolicyKind, QoSProfile, ReliabilityPolicy
from rclpy.qos_overriding_options import QoSOverridingOptions

PREFIX = 'qos_overrides.'
PUBLISHER, SUBSCRIPTION = 'publisher', 'subscription'
_POLICIES = {
    kind.name.lower(): kind
    for kind in QoSPolicyKind.__members__.values()
    if kind != QoSPolicyKind.INVALID
}
MOST_DEPTH = 2**31 - 1  # [messages] what DDS counts
ALLOWED = (
    f'depth 1 to {MOST_DEPTH}, history keep_last or keep_all, reliability reliable or '
    'best_effort, durability volatile or transient_local'
)


class QosOverrides:
    """
    The overrides among the given parameters; each is asked for by the topic that it names.

    given : names of all given parameters
    """

    def __init__(self, given: Iterable[str]) -> None:
        self._given = {name for name in given if name.startswith(PREFIX)}
        self._taken: set[str] = set()

    def options(
        self, topic: str, end: str, *, must_be_reliable: bool = False
    ) -> QoSOverridingOptions | None:
        """
        Give the options of a publisher or subscription; None where nothing names it.

        topic : resolved name
        end   : PUBLISHER or SUBSCRIPTION
        must_be_reliable : refuse best effort
        """
        if not self._given:
            return None
        stem = f'{PREFIX}{topic}.{end}.'
        named = {
            name: _POLICIES[name.removeprefix(stem)]
            for name in self._given
            if name.startswith(stem) and name.removeprefix(stem) in _POLICIES
        }
        self._taken |= named.keys()
        judge = partial(_judge, must_be_reliable=must_be_reliable)
        return QoSOverridingOptions(list(named.values()), callback=judge) if named else None

    def warnings(self) -> list[str]:
        """One line for each override that no topic took."""
        return [
            f'parameter {name} has no effect; it takes the resolved name of a topic of this node, '
            f'as in qos_overrides./box/pose.publisher.depth; policies: {", ".join(_POLICIES)}'
            for name in sorted(self._given - self._taken)
        ]


def _judge(profile: QoSProfile, *, must_be_reliable: bool) -> SetParametersResult:
    """Judge a profile with its overrides, before the middleware stumbles over it."""
    reason = ''
    if not 1 <= profile.depth <= MOST_DEPTH:
        reason = f'depth {profile.depth}'
    elif must_be_reliable and profile.reliability != ReliabilityPolicy.RELIABLE:
        reason = 'best_effort on a topic of lock-step, which waits for each answer'
    return SetParametersResult(successful=not reason, reason=reason)
