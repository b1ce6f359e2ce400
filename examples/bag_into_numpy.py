# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A bag into numpy: what a run recorded, as arrays.

A bag is an ordinary rosbag2 directory with MCAP storage: ROS, Foxglove and `rosbags` read it too.
Here the package's own reader is used, which needs none of them.
"""

import math
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.bag_reader import Bag

folder = Path(tempfile.mkdtemp())
subprocess.run(
    [
        *(sys.executable, '-m', 'rigid_body_sim', 'simulate', 'two_bodies'),
        *('-o', 'run', '--duration', '2', '--json'),
    ],
    cwd=folder,
    stdout=subprocess.DEVNULL,
    check=True,
)

bag = Bag(folder / 'run')
print(bag.manifest['integrator'], 'recorded', sum(bag.counts.values()), 'messages on')
print(' ', ', '.join(bag.topics))

times, positions = [], []
for message in bag.messages(['/ball/pose']):
    pose = cdr.decode('geometry_msgs/msg/PoseStamped', message.data)
    times.append(pose.sec + pose.nanosec * 1e-9)
    positions.append(pose.position)
time, position = np.array(times), np.array(positions)

print(f'ball: {len(time)} poses from {time[0]:.2f} s to {time[-1]:.2f} s')
print(
    f'      lowest point {position[:, 2].min():.3f} m, farthest {abs(position[:, 0]).max():.3f} m'
)
assert position.shape == (len(time), 3) and math.isclose(time[-1], 2.0)
