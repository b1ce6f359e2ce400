# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""What `make venv` installs is locked whole: one version for each Python, files by their hash."""

import re
from functools import cache
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parents[2] / 'requirements'
LISTS = ('runtime', 'ros', 'test')
PYTHONS = ('3.10', '3.11', '3.12', '3.13')


@cache
def locked():
    """Every entry of the locks: (requirement, its hashes)."""
    found = []
    for name in ('locked', 'locked_ros', 'locked_test'):
        for entry in re.split(r'(?m)^(?=[^\s#])', (ROOT / f'{name}.txt').read_text())[1:]:
            head, *hashes = (line.strip(' \\') for line in entry.splitlines())
            found.append((Requirement(head), hashes))
    return found


@cache
def required_by(name):
    """The version of a package that is installed here and what it requires, or None."""
    try:
        installed = distribution(name)
    except PackageNotFoundError:  # of another Python, or ROS is sourced
        return None
    return installed.version, [*map(Requirement, installed.requires or ())]


def machine(python):
    """Marker values of Linux with that Python."""
    return {
        'python_version': python,
        'python_full_version': f'{python}.9',
        'sys_platform': 'linux',
        'platform_system': 'Linux',
        'platform_machine': 'x86_64',
    }


def versions(python):
    """
    What one Python gets: name -> specifier; two versions of a name, or an entry twice, fail.

    `name[extra]` has an entry of its own beside `name`: pip takes it for another package, and
    would look for the newest one.
    """
    found, extras = {}, set()
    for requirement, _ in locked():
        if requirement.marker is None or requirement.marker.evaluate(machine(python)):
            name = canonicalize_name(requirement.name)
            entry = name, *sorted(requirement.extras)
            assert entry not in extras, f'{entry} is locked twice for Python {python}'
            extras.add(entry)
            specifier = str(requirement.specifier)
            assert found.setdefault(name, specifier) == specifier, f'two versions of {name}'
    return found


def test_each_entry_is_one_version_with_the_hashes_of_its_files():
    entries = list(locked())
    assert len(entries) > 150
    for requirement, hashes in entries:
        assert re.fullmatch('==[^*,]+', str(requirement.specifier)), requirement
        assert requirement.url is None
        assert hashes, f'{requirement.name} has no hash'
        assert all(re.fullmatch('--hash=sha256:[0-9a-f]{64}', line) for line in hashes)


@pytest.mark.parametrize('python', PYTHONS)
def test_the_lock_holds_what_the_lists_pin(python):
    found = versions(python)
    for name in LISTS:
        lines = (ROOT / f'{name}.txt').read_text().splitlines()
        for line in filter(None, (line.partition('#')[0].strip() for line in lines)):
            pin = Requirement(line)
            if pin.marker is None or pin.marker.evaluate(machine(python)):
                assert found[canonicalize_name(pin.name)] == str(pin.specifier)


@pytest.mark.parametrize('python', PYTHONS)
def test_extras_that_a_locked_package_requires_are_locked_by_name(python):
    """Else an installation breaks as soon as a newer version is published (coverage[toml])."""
    entries = {
        (canonicalize_name(requirement.name), extra)
        for requirement, _ in locked()
        for extra in requirement.extras
        if requirement.marker is None or requirement.marker.evaluate(machine(python))
    }
    assert ('coverage', 'toml') in entries
    for name in versions(python):
        _version, requires = required_by(name) or ('', ())
        for requirement in requires:
            marker = requirement.marker
            if marker is None or marker.evaluate({**machine(python), 'extra': ''}):
                for extra in requirement.extras:
                    assert (canonicalize_name(requirement.name), extra) in entries


@pytest.mark.parametrize('python', PYTHONS)
def test_what_a_locked_package_requires_is_locked_too(python):
    """Of the packages that are installed here: what they ask for on any Python is in the lock."""
    found = versions(python)
    asked = 0
    for name, locked_as in found.items():
        version, requires = required_by(name) or ('', ())
        for requirement in requires if f'=={version}' == locked_as else ():
            marker = requirement.marker
            if marker is None or marker.evaluate({**machine(python), 'extra': ''}):
                asked += 1
                specifier = found[canonicalize_name(requirement.name)]
                assert requirement.specifier.contains(
                    specifier.removeprefix('=='), prereleases=True
                )
    assert asked > 50
