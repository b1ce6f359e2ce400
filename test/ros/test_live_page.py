# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The live page of a running node: what it publishes arrives, in scene order, with the node's scene.
"""

import time

import numpy as np

from rigid_body_sim.ros.state_listener import StateListener
from rigid_body_sim.scene import load_scene
from rigid_body_sim.view.growing_motion import joined

from ..patience import PATIENCE


def test_the_states_of_a_node_arrive_with_its_scene(start_node, meet):
    node = start_node()
    meet(node).be_known()
    with StateListener(node.namespace) as listener:
        blocks = [listener.begin()]
        deadline = time.monotonic() + PATIENCE
        while sum(len(block.tracks[0].time) for block in blocks) < 20:
            assert time.monotonic() < deadline
            block = listener.more()
            if block is not None:
                blocks.append(block)
        scene = load_scene(node.folder / 'laboratory.yaml')
        assert listener.scene is not None and listener.title == scene.name
    motion = joined(blocks)
    assert [track.name for track in motion.tracks] == [body.name for body in scene.bodies]
    for track, body in zip(motion.tracks, scene.bodies, strict=True):
        assert np.array_equal(track.time, track.twist_time)
        ticks = np.diff(track.time) / 0.01  # [s] published a hundred times a second
        assert np.all(ticks > 0.5) and np.allclose(ticks, np.round(ticks), atol=1e-6)
        # nothing pushes anybody: all stay, to the bit, where the scene puts them
        assert np.all(track.position == body.initial.position)
