# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""One message of a recording."""

from __future__ import annotations

from typing import NamedTuple


class RecordedMessage(NamedTuple):
    """
    One message as the file holds it.

    topic    : absolute name
    sequence : tick (see `packing`); 0 in bags of other recorders
    log_time : [ns] simulation time in our bags
    data     : CDR payload
    publish_time : [ns] equal to log_time in our bags
    """

    topic: str
    sequence: int
    log_time: int
    data: bytes
    publish_time: int
