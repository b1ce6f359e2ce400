# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What is installed: the modules, the executables, the scenes, node parameters and what viewers
read, the launch file.

`ros2 run` looks for one executable per verb in `lib/rigid_body_sim`. colcon and the build farm
install by `setup.py install` or `develop`, and setup.cfg sends the scripts there. pip asks for a
wheel: of that, `rigid_body_sim` alone goes on the path (`rigid_body_sim VERB`), because names like
view and report belong to others, and `lib/rigid_body_sim` gets a line of shell for each verb.
Scenes go to `share/rigid_body_sim/config`, in a pip installation below `sys.prefix`.
"""

import sys
from pathlib import Path

from setuptools import find_packages, setup

NAME = 'rigid_body_sim'
HERE = Path(__file__).parent
VERBS = (
    'bag',
    'export',
    'inspect',
    'inverse',
    'list',
    'replay',
    'report',
    'sim_node',
    'simulate',
    'sweep',
    'view',
    'warm_up',
    'wrench_pub',
)

FUNCTIONS = {'list': 'list_what_there_is'}  # whose name Python has for something else

FOR_WHEEL = not {'install', 'develop'} & set(sys.argv)
LAUNCHER = """#!/bin/sh
exec "$(dirname "$0")/../../bin/{name}" {verb} "$@"
"""


def console_scripts() -> list[str]:
    """
    The scripts that are made where this installation puts them.
    """
    if FOR_WHEEL:
        return [f'{NAME} = {NAME}.executables:command']
    return [f'{verb} = {NAME}.executables:{FUNCTIONS.get(verb, verb)}' for verb in VERBS]


def launchers() -> list[tuple[str, list[str]]]:
    """
    What `ros2 run` finds after `pip install`: written below `build/`, for a wheel only.
    """
    if not FOR_WHEEL:
        return []
    folder = HERE / 'build' / 'launchers'
    folder.mkdir(parents=True, exist_ok=True)
    for verb in VERBS:
        (folder / verb).write_text(LAUNCHER.format(name=NAME, verb=verb), encoding='utf-8')
        (folder / verb).chmod(0o755)
    return [(f'lib/{NAME}', [f'build/launchers/{verb}' for verb in VERBS])]


def config_files() -> list[tuple[str, list[str]]]:
    """
    Every file below `config/`, paired with the folder of the same name below `share`.
    """
    folders = [HERE / 'config', *(path for path in (HERE / 'config').rglob('*') if path.is_dir())]
    return [
        (
            f'share/{NAME}/{folder.relative_to(HERE).as_posix()}',
            sorted(
                path.relative_to(HERE).as_posix() for path in folder.iterdir() if path.is_file()
            ),
        )
        for folder in sorted(folders)
    ]


setup(
    name=NAME,
    version='0.1.0',
    description='Rigid bodies that answer forces and torques over ROS 2 topics',
    author='rigid_body_sim maintainers',
    maintainer='rigid_body_sim maintainers',
    url='https://github.com/rigid-body-sim/rigid_body_sim',
    maintainer_email='rigid_body_sim@users.noreply.github.com',
    license='Apache-2.0',
    python_requires='>=3.10',
    packages=find_packages(include=[NAME, f'{NAME}.*']),
    package_data={
        NAME: ['py.typed'],
        f'{NAME}.physics.compile': ['shipped/*/*.kernel'],  # of `warm_up --bitcode`, if any
        f'{NAME}.view': ['page/*', 'vendor/*'],
        f'{NAME}.report': ['assets/*'],
        f'{NAME}.ros': ['*.xml'],
        f'{NAME}.testing': ['*.xml'],
    },
    install_requires=[
        'setuptools',
        'matplotlib',
        'mcap',
        'numba',
        'numpy',
        'PyYAML',
        'scipy',
        'tqdm',
        'trimesh',
    ],
    extras_require={
        'dask': ['dask', 'distributed', 'pandas', 'pyarrow'],
        'decomposition': ['coacd'],
        'gym': ['gymnasium'],
        'peers': ['mujoco', 'drake', 'dartpy', 'pin', 'rapier3d'],
        'tables': ['pandas', 'pyarrow', 'xarray'],
        'test': [
            'hypothesis',
            'mcap-ros2-support',
            'mpmath',
            'psutil',
            'pytest',
            'rosbags',
            'yourdfpy',
        ],
        'urdf': ['lxml', 'yourdfpy'],
    },
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{NAME}']),
        (f'share/{NAME}', ['package.xml']),
        (f'share/{NAME}/launch', ['launch/sim_node.launch.py']),
        *config_files(),
        *launchers(),
    ],
    entry_points={
        'console_scripts': console_scripts(),
        # named as the module, so that `-p` of it is the same plugin
        'pytest11': [f'{NAME}.testing.plugin = {NAME}.testing.plugin'],
    },
    zip_safe=True,
)
