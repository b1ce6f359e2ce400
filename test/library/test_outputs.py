# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Outputs at a path where something else than a file is: links, pipes and devices stay."""

import os
import stat

import pytest

import rigid_body_sim as rbs
from rigid_body_sim.errors import RunError, UserError

NULL, FULL = (1, 3), (1, 7)  # numbers of these devices on Linux


@pytest.fixture(scope='module')
def run():
    return rbs.simulate('two_bodies', 0.1, every=0.01)


@pytest.fixture(params=['checkpoint', 'csv', 'parquet'])
def writer(request, run):
    """
    What writes to a path.
    """
    if request.param == 'parquet':
        pytest.importorskip('pyarrow')
        return run.to_parquet
    return run.to_csv if request.param == 'csv' else rbs.Simulation('two_bodies').save


@pytest.fixture
def device(tmp_path):
    """
    A device of our own; never that of the machine, which would be gone where this fails.
    """

    def make(numbers):
        path = tmp_path / 'device'
        try:
            os.mknod(path, 0o666 | stat.S_IFCHR, os.makedev(*numbers))
            with path.open('wb'):
                pass
        except OSError as error:
            pytest.skip(f'no device can be made here: {error}')
        return path

    return make


def test_a_link_stays_and_what_it_leads_to_is_replaced(writer, tmp_path):
    (tmp_path / 'far').mkdir()
    place = tmp_path / 'far' / 'file'
    link, second = tmp_path / 'link', tmp_path / 'second'
    link.symlink_to('far/file')
    second.symlink_to(link)
    for before in (None, b'before'):  # a link that leads nowhere yet, too
        if before is not None:
            place.write_bytes(before)
        writer(second)
        assert link.is_symlink() and second.is_symlink() and len(place.read_bytes()) > 500
    assert sorted(path.name for path in tmp_path.rglob('*')) == ['far', 'file', 'link', 'second']


def test_a_link_to_itself_is_refused(writer, tmp_path):
    link = tmp_path / 'link'
    link.symlink_to(link)
    with pytest.raises(UserError, match='link: a symbolic link that leads back to itself'):
        writer(link)
    assert link.is_symlink()


def test_a_device_is_written_to_and_stays(writer, device):
    path = device(NULL)
    writer(path)
    assert stat.S_ISCHR(path.stat().st_mode)
    assert [each.name for each in path.parent.iterdir()] == ['device']


def test_a_device_that_is_full_is_named_and_stays(writer, device):
    path = device(FULL)
    with pytest.raises(RunError, match='device: cannot be written: No space left on device; '):
        writer(path)
    assert stat.S_ISCHR(path.stat().st_mode)


def test_a_pipe_gets_what_a_file_gets_and_is_refused_where_nobody_reads(writer, tmp_path):
    place, pipe = tmp_path / 'file', tmp_path / 'pipe'
    writer(place)
    assert place.stat().st_size < 65536  # what a pipe holds of itself
    os.mkfifo(pipe)
    with pytest.raises(UserError, match=r'pipe: cannot be written: .*; if it is a pipe, let'):
        writer(pipe)
    with os.fdopen(os.open(pipe, os.O_RDONLY | os.O_NONBLOCK), 'rb') as reader:
        writer(pipe)
        assert reader.read() == place.read_bytes()
    assert stat.S_ISFIFO(pipe.stat().st_mode)
