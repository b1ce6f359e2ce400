# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The walls between the rooms, read from the import statements.

A room may import what its row names, the standard library, and itself.
Who is not in the table may import anything but ROS.
"""

import ast
import sys
from pathlib import Path

import pytest

NAME = 'rigid_body_sim'
ROOT = Path(__file__).parents[2]
MODULES = sorted((ROOT / NAME).rglob('*.py'))
HEADER = ['# Copyright 2026 rigid_body_sim maintainers', '# SPDX-License-Identifier: Apache-2.0']
LONGEST = 400  # [lines] a longer module is a room that wants splitting
NUMERIC = {'numpy', 'scipy'}
PEERS = {'dartpy', 'mujoco', 'pinocchio', 'pybullet', 'pydrake', 'rapier3d'}  # in report/peers
WALLS = {  # room -> what it may import besides the standard library and itself
    'physics': NUMERIC | {'numba'},
    'exact': NUMERIC,
    'recording': {'numpy', 'mcap', 'yaml', 'lz4', 'zstandard', f'{NAME}.errors'},
    'scene': {'numpy', 'yaml', 'trimesh', 'lxml', 'yourdfpy', f'{NAME}.physics', f'{NAME}.errors'},
    'report': NUMERIC
    | {'PIL', 'matplotlib', 'yaml', f'{NAME}.__version__', f'{NAME}.errors'}
    | {f'{NAME}.physics', f'{NAME}.exact', f'{NAME}.scene'}
    | PEERS,
    'errors': set(),
}
SPEAK_ROS = {'ros', 'verbs.sim_node', 'verbs.wrench_pub'}


def within(name: str, rooms: set[str]) -> bool:
    """
    Whether a dotted name is one of the rooms or lies inside one.
    """
    return any(name == room or name.startswith(f'{room}.') for room in rooms)


def imports(path: Path) -> set[str]:
    """
    Absolute dotted names of everything a module imports, function bodies included.
    """
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding='utf-8'))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f'{path}:{node.lineno}: relative import; name the room'
            found |= {f'{node.module}.{alias.name}' for alias in node.names}
    return found


def room_of(path: Path) -> str:
    """
    Dotted name of a module below the package: `physics.model`, `scene`, `verbs.view`.
    """
    return '.'.join(path.relative_to(ROOT / NAME).with_suffix('').parts).removesuffix('.__init__')


def is_ros(name: str) -> bool:
    """
    Whether an import is rclpy, a package of messages or services, or what comes with them.
    """
    top = name.partition('.')[0]
    return top.endswith(('_msgs', '_srvs', '_interfaces')) or top in {
        'rclpy',
        'rosidl_runtime_py',
        'rpyutils',
    }


@pytest.mark.parametrize('path', MODULES, ids=room_of)
def test_each_room_imports_only_what_its_wall_lets_through(path):
    room = room_of(path)
    for wall, allowed in WALLS.items():
        if within(room, {wall}):
            own = allowed | {f'{NAME}.{wall}'} | set(sys.stdlib_module_names)
            strangers = {name for name in imports(path) if not within(name, own)}
            assert not strangers, f'{path}: {wall} must not import {sorted(strangers)}'


@pytest.mark.parametrize('path', MODULES, ids=room_of)
def test_only_the_ros_room_and_its_two_verbs_know_ros(path):
    room = room_of(path)
    if not within(room, {'ros'}):
        assert not {name for name in imports(path) if is_ros(name)}, f'{path} speaks ROS'
    if not within(room, SPEAK_ROS):
        assert not {name for name in imports(path) if within(name, {f'{NAME}.ros'})}, (
            f'{path} imports the ROS room'
        )


@pytest.mark.parametrize('path', MODULES, ids=room_of)
def test_nothing_leans_on_the_report_but_its_verb(path):
    room = room_of(path)
    if not within(room, {'report', 'verbs.report'}):
        assert not {name for name in imports(path) if within(name, {f'{NAME}.report'})}, path


@pytest.mark.parametrize('path', MODULES, ids=room_of)
def test_peers_are_imported_in_their_files_alone(path):
    if not within(room_of(path), {'report.peers'}):
        assert not {name for name in imports(path) if within(name, PEERS)}, path


@pytest.mark.parametrize('path', MODULES, ids=room_of)
def test_no_module_outgrows_its_noun(path):
    assert len(path.read_text(encoding='utf-8').splitlines()) <= LONGEST


def test_every_python_file_carries_the_licence():
    kept = ['setup.py', NAME, 'test', 'tools', 'benchmark']
    files = [
        path
        for top in kept
        for path in [ROOT / top, *(ROOT / top).rglob('*.py')]
        if path.is_file()
    ]
    assert not [
        str(path) for path in files if path.read_text(encoding='utf-8').splitlines()[:2] != HEADER
    ]
