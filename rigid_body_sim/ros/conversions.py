# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Between messages and what the rest of the node speaks: the only place that touches their fields.

Commands and states never become message objects: their bytes are read and written by
`recording.cdr`, which costs a fifth and gives equal bytes for equal values.
"""

from __future__ import annotations

from contextlib import suppress
from typing import Any, TypeVar

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import PoseArray, PoseStamped, TwistStamped, Vector3Stamped, WrenchStamped
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import MultiDOFJointState, PointCloud2
from std_srvs.srv import SetBool, Trigger
from visualization_msgs.msg import MarkerArray

from rigid_body_sim.recording import cdr
from rigid_body_sim.ros.health import ERROR, OK, WARN, Health
from rigid_body_sim.ros.requests import Answer

MESSAGE_TYPES: dict[str, Any] = {
    cdr.Clock.TYPE: Clock,
    cdr.PoseStamped.TYPE: PoseStamped,
    cdr.TwistStamped.TYPE: TwistStamped,
    cdr.WrenchStamped.TYPE: WrenchStamped,
    cdr.Vector3Stamped.TYPE: Vector3Stamped,
    cdr.PointCloud2.TYPE: PointCloud2,
    cdr.Odometry.TYPE: Odometry,
    cdr.POSE_ARRAY: PoseArray,
    cdr.TWIST_ARRAY: MultiDOFJointState,
    cdr.MARKERS: MarkerArray,
}
with suppress(ImportError):  # not part of common_interfaces: a small installation has none
    from tf2_msgs.msg import TFMessage  # type: ignore[import-not-found]

    MESSAGE_TYPES[cdr.TRANSFORMS] = TFMessage
DIAGNOSTICS = 'diagnostic_msgs/msg/DiagnosticArray'
_LEVELS = {OK: DiagnosticStatus.OK, WARN: DiagnosticStatus.WARN, ERROR: DiagnosticStatus.ERROR}


def wanted(request: SetBool.Request) -> bool:
    """Read whether a SetBool asks for on or off."""
    return request.data


Response = TypeVar('Response', SetBool.Response, Trigger.Response)


def answered(response: Response, answer: Answer) -> Response:
    """Fill in the response of a service."""
    response.success, response.message = answer
    return response


def figures(array: DiagnosticArray, *, node_name: str) -> dict[str, str]:
    """Give what `diagnostics` of a node says, by name; of others nothing."""
    own = _status_name(node_name)
    told = [status for status in array.status if status.name == own]
    return {pair.key: pair.value for status in told for pair in status.values}


def _status_name(node_name: str) -> str:
    return f'{node_name}: simulation'


def diagnostics(health: Health, *, node_name: str, stamp: Time) -> DiagnosticArray:
    """Give the figures of a run as one status; `stamp`: wall time."""
    status = DiagnosticStatus(
        level=_LEVELS[health.level],
        name=_status_name(node_name),
        message=health.message,
        hardware_id=health.scene,
        values=[KeyValue(key=key, value=value) for key, value in health.values().items()],
    )
    array = DiagnosticArray(status=[status])
    array.header.stamp = stamp
    return array
