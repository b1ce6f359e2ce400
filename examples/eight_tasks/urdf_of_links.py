# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A robot of three links on fixed joints becomes one body: a union of what its links are."""

from pathlib import Path

import numpy as np
from yourdfpy import URDF

import rigid_body_sim as rbs

robot, parts = URDF.load(str(Path(__file__).with_name('three_links.urdf'))), []
for name, link in robot.link_map.items():
    pose = robot.get_transform(name) @ link.collisions[0].origin
    shape = rbs.Box(tuple(link.collisions[0].geometry.box.size))
    turn = tuple(rbs.rotation.from_matrix(pose[:3, :3]))
    parts.append(rbs.Part(shape, link.inertial.mass, None, tuple(pose[:3, 3]), turn))
body = rbs.make_body('robot', rbs.Union(tuple(parts)))
print(f'{body.mass:g} kg, centre of mass {np.round(body.center_of_mass, 4)} m')
run = rbs.simulate(rbs.make_scene([body], gravity=(0, 0, -9.81)), duration=1, every=0.1)
assert abs(run['robot'].velocity[-1, 2] + 9.81) < 1e-12  # m/s; it falls as one
