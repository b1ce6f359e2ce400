# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A corner of a cube, read from a mesh, falls onto the ground and comes to rest on a face."""

from pathlib import Path

import rigid_body_sim as rbs

shipped = Path(__file__).parents[2] / 'config/scenes'
mesh = {'type': 'mesh', 'file': str(shipped / 'meshes/tetrahedron.off')}
start = {'position': [0, 0, 0.4], 'angular_velocity': [1, 2, 0]}
ground = {'name': 'ground', 'shape': {'type': 'plane', 'normal': [0, 0, 1]}}
corner = {'name': 'corner', 'shape': mesh, 'density': 600, 'initial': start}
scene = {'dt': 0.004, 'gravity': [0, 0, -9.81], 'contact': {'mode': 'timestep'}}
run = rbs.simulate({**scene, 'bodies': [ground, corner]}, duration=4, every=0.04)
height = run['corner'].position[:, 2]
print(f'it falls from {height[0]:g} m and rests with its centre at {height[-1]:.4f} m')
assert abs(height[-1] - 0.075) < 1e-4  # m: a quarter of an edge of 0.3 m, on a side of the cube
