# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""package.xml: what a build farm needs, and of ROS what is imported, no more and no less."""

import ast
import re
from pathlib import Path
from xml.etree import ElementTree

import pytest

ROOT = Path(__file__).parents[2]
PACKAGE = ElementTree.parse(ROOT / 'package.xml').getroot()
BY_NAME = {'tf2_msgs', 'simulation_interfaces', 'rviz2'}  # imported where installed, or started
OF_ROS = r'rclpy|launch|launch_ros|std_srvs|rcl_interfaces|\w+_msgs|\w+_interfaces'


def declared(kind):
    return {each.text for each in PACKAGE.findall(kind)}


def sources():
    """The modules of the package, and its launch files."""
    return [*(ROOT / 'rigid_body_sim').rglob('*.py'), *(ROOT / 'launch').glob('*.py')]


def imported_of_ros(texts):
    """Top-level names of what modules import of ROS, wherever it stands in them."""
    names = set()
    for text in texts:
        if not re.search(OF_ROS, text):
            continue  # it takes long to read them all
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.Import):
                names |= {alias.name.partition('.')[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module:
                names.add(node.module.partition('.')[0])
    return {name for name in names if re.fullmatch(OF_ROS, name)}


def test_of_ros_it_declares_what_it_imports():
    ros = {name for name in declared('exec_depend') if not name.startswith('python3-')}
    texts = [path.read_text(encoding='utf-8') for path in sources()]
    by_name = {name for name in BY_NAME if any(name in text for text in texts)}
    assert imported_of_ros(texts) | by_name == ros


def test_no_key_names_pip_and_no_linter_of_ament_is_declared():
    keys = set().union(*(declared(kind) for kind in ('depend', 'exec_depend', 'test_depend')))
    assert not [key for key in keys if key.endswith('-pip') or key.startswith('ament_')]


def test_it_says_who_where_and_under_which_license():
    (maintainer,) = PACKAGE.findall('maintainer')
    address = maintainer.get('email')
    assert re.fullmatch(r'[\w.+-]+@[\w-]+(\.[\w-]+)+', address)
    assert not re.search(r'\.(example|invalid|test|localhost)$', address)
    assert {each.get('type') for each in PACKAGE.findall('url')} == {'repository', 'bugtracker'}
    assert declared('author')
    assert (ROOT / PACKAGE.find('license').get('file')).is_file()
    assert (ROOT / PACKAGE.find('export/rosdoc2').text).is_file()


def test_it_is_what_ros_takes_for_a_package():
    package = pytest.importorskip('catkin_pkg.package')
    warnings = []
    found = package.parse_package(ROOT / 'package.xml', warnings=warnings)
    found.validate(warnings=warnings)
    assert not warnings
    assert found.version in (ROOT / 'setup.py').read_text()
