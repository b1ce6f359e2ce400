# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What is installed: the modules, one executable per verb, the scenes, node parameters and what
viewers read, the launch file.

Executables go to `lib/rigid_body_sim` (setup.cfg), where `ros2 run` looks. Scenes go to
`share/rigid_body_sim/config`, in a colcon workspace as well as in a pip installation (there below
`sys.prefix`).
"""

from pathlib import Path

from setuptools import find_packages, setup

NAME = 'rigid_body_sim'
HERE = Path(__file__).parent
VERBS = (
    'bag',
    'inspect',
    'inverse',
    'replay',
    'report',
    'sim_node',
    'simulate',
    'view',
    'wrench_pub',
)


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
    maintainer='rigid_body_sim maintainers',
    maintainer_email='maintainers@rigid-body-sim.example',
    license='Apache-2.0',
    python_requires='>=3.10',
    packages=find_packages(include=[NAME, f'{NAME}.*']),
    package_data={NAME: ['py.typed'], f'{NAME}.view': ['*.html'], f'{NAME}.report': ['assets/*']},
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
        'peers': ['mujoco', 'drake', 'dartpy', 'pin', 'rapier3d'],
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
    ],
    entry_points={
        'console_scripts': [f'{verb} = {NAME}.__main__:{verb}' for verb in VERBS],
    },
    zip_safe=True,
)
