# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Words behind a verb that there are none of, and outputs that are full: one line that says what and
what to do.
"""

import errno
import os
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path
from threading import Barrier

import pytest

from rigid_body_sim.__main__ import VERBS, main
from rigid_body_sim.command_line import decimal
from rigid_body_sim.errors import UserError
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.recording.mcap_file import McapFile
from rigid_body_sim.recording.new_output import as_text, replacing
from rigid_body_sim.scene.shipped_scenes import find_scene

from ..patience import HANGING

NODE_VERBS = ('sim_node', 'wrench_pub', 'view')  # want ROS, or matplotlib


def refused(words, capsys):
    """Return the one line with which words are refused."""
    with pytest.raises(SystemExit) as stopped:
        main(words)
    assert stopped.value.code == 2
    out, err = capsys.readouterr()
    assert out == '' and err.count('\n') == 1
    return err


@pytest.mark.parametrize(
    ('words', 'said'),
    [
        ('simulate box --integrater rk4', "simulate: error: unknown option '--integrater'; did "),
        ('simulate box --durations 3', "'--durations'; did you mean '--duration'? allowed: --h"),
        ('simulate box -o b --duraton=3', "'--duraton'; did you mean '--duration'? allowed: --"),
        ('bag chekc x', "unknown action 'chekc'; did you mean 'check'? allowed: info, check, rec"),
        ('bag check --jsno x', "bag check: error: unknown option '--jsno'; did you mean '--json'"),
        ('sweep box --zzz 3', "unknown option '--zzz'; allowed: --help, --vary, "),
    ],
)
def test_a_misspelt_word_is_named_with_the_nearest_there_is(words, said, capsys):
    assert said in refused(words.split(), capsys)


@pytest.mark.parametrize('number', ['1_0', '010', '0x10', '1:30', '１０', 'ten'])
@pytest.mark.parametrize(
    'words', ['simulate box -o b --duration', 'warm_up box --jobs', 'view b --port', 'inspect box']
)
def test_a_number_is_one_where_a_scene_has_it_as_one(words, number, capsys):
    words = words.split()
    words += ['--axis', 'box', '0', number, '1'] if words == ['inspect', 'box'] else [number]
    if words[0] == 'inspect':
        words[1] = str(find_scene('tumbling_box'))
        assert main(words) == 2
    else:
        with pytest.raises(SystemExit) as stopped:
            main(words)
        assert stopped.value.code == 2
    out, err = capsys.readouterr()
    assert out == '' and f"'{number}' is no number" in err
    assert ('in decimal without leading zeros' in err) == (number[0] in '01')


@pytest.mark.parametrize('number', ['10', '+10', '1e1', '10.', ' 10'])
def test_a_number_may_have_every_form_that_a_scene_allows(number):
    assert decimal(number) == 10.0


@pytest.mark.parametrize('verb', sorted(VERBS.keys() - set(NODE_VERBS)))
def test_every_verb_names_its_options(verb, capsys):
    words = [verb, 'info'] if verb == 'bag' else [verb]
    assert "unknown option '--jsonn'" in refused([*words, '--jsonn'], capsys)


def test_an_option_may_be_shortened_and_a_name_may_begin_with_dashes(capsys, tmp_path):
    assert main(['inspect', 'two_bodies', '--js']) == 0
    assert capsys.readouterr().out.startswith('{')
    assert main(['inspect', '--', '--box']) == 2  # no such file, and no such option asked for
    assert 'unknown option' not in capsys.readouterr().err


needs_full = pytest.mark.skipif(not Path('/dev/full').exists(), reason='no /dev/full here')


@needs_full
@pytest.mark.parametrize(
    'words', ['list scenes', 'inspect two_bodies', 'simulate --help', '--version', '--help']
)
def test_a_full_standard_output_is_named(words, capsys, monkeypatch):
    with open('/dev/full', 'w', buffering=1) as full:  # noqa: PTH123  (no file is made)
        monkeypatch.setattr('sys.stdout', full)
        assert main(words.split()) == 1
        monkeypatch.undo()
        assert capsys.readouterr().err.partition('error: ')[2] == (
            'standard output: cannot be written (No space left on device); make room where it '
            'goes, or send it elsewhere\n'
        )
        with suppress(OSError):  # what it still holds
            full.close()


TOO_STIFF = """version: 1
name: stiff
dt: 0.1
integrator: explicit_euler
bodies:
  - {name: ball, shape: {type: sphere, radius: 0.1}, mass: 1, initial: {position: [1, 0, 0]}}
forces: [{type: spring, a: ball, b: world, stiffness: 100, b_point: [0, 0, 0]}]
"""  # of which a run warns


@pytest.mark.parametrize(
    'streams',
    [
        '<&- >&- 2>&-',
        pytest.param('2>/dev/full', marks=needs_full),
        *(pytest.param(s, marks=pytest.mark.long) for s in ('1</dev/null 2</dev/null', '2>&-')),
    ],
)
@pytest.mark.usefixtures('plain_source')
def test_a_run_whose_streams_the_parent_closed_is_whole(streams, tmp_path, capsys):
    scene, bag = tmp_path / 'stiff.yaml', tmp_path / 'bag'
    scene.write_text(TOO_STIFF)
    words = f'"{sys.executable}" -m rigid_body_sim simulate "{scene}" --duration 1 -o "{bag}"'
    ended = subprocess.run(
        ['/bin/sh', '-c', f'exec {words} {streams}'],
        env=os.environ
        | {'PYTHONPATH': str(Path(__file__).parents[2]), 'RIGID_BODY_SIM_COMPILE': '0'},
        stdout=subprocess.DEVNULL,
        timeout=HANGING,
        check=False,
    )
    assert ended.returncode == 0
    assert main(['replay', str(bag)]) == 0
    assert 'warning: ' in capsys.readouterr().err


def test_a_program_without_streams_may_call_a_verb(monkeypatch):
    monkeypatch.setattr('sys.stdout', None)
    monkeypatch.setattr('sys.stderr', None)
    assert main(['list', 'scenes']) == 0
    assert main(['inspect', 'none']) == 2
    assert main(['--version']) == 0
    assert sys.stdout is None


def test_help_keeps_its_paragraphs_and_the_width_of_the_terminal(capsys, monkeypatch):
    monkeypatch.setenv('COLUMNS', '60')
    for verb in sorted(VERBS.keys() - set(NODE_VERBS)):
        with pytest.raises(SystemExit):
            main([verb, '--help'])
        lines = capsys.readouterr().out.splitlines()
        assert max(map(len, lines)) <= 60, verb
        assert verb != 'export' or lines.count('') > 4


@pytest.mark.parametrize('name', ['x.csv', 'x.html'])
def test_what_cannot_be_taken_away_hides_no_cause(name, tmp_path, monkeypatch):
    def read_only(path, *_arguments, **_options):
        raise OSError(errno.EROFS, os.strerror(errno.EROFS), str(path))

    monkeypatch.setattr(Path, 'unlink', read_only)
    with (
        pytest.raises(UserError, match=f'{name}: cannot be written: Read-only file system; '),
        replacing(tmp_path / name) as new,
    ):
        read_only(new)


def test_of_two_threads_that_write_one_file_the_last_one_has_it_whole(tmp_path):
    path, both = tmp_path / 'x.csv', Barrier(2)

    def write(text):
        with replacing(path) as new:
            both.wait(timeout=HANGING)
            new.write_text(text)
            both.wait(timeout=HANGING)

    with ThreadPoolExecutor(2) as threads:
        list(threads.map(write, ['one', 'two']))
    assert path.read_text() in {'one', 'two'}
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    'words',
    [
        'simulate two_bodies --duration 0.1',
        'replay {bag}',
        'inverse {bag}',
        'bag recover {bag}',
        'sweep two_bodies --vary dt=0.001 --duration 0.1',
    ],
)
def test_a_bag_whose_name_is_no_text_is_refused_before_it_is_begun(words, tmp_path, capsys):
    good, bad = tmp_path / 'good', tmp_path / 'M\udcfcnchen'
    if '{bag}' in words:
        assert main(['simulate', 'two_bodies', '--duration', '0.1', '-o', str(good)]) == 0
    capsys.readouterr()
    assert main([*words.format(bag=good).split(), '-o', str(bad)]) == 2
    said = capsys.readouterr().err
    assert r'M\udcfcnchen: holds bytes that are no text in UTF-8' in said
    assert 'LC_ALL=C.UTF-8' in said
    assert not bad.exists()


@pytest.mark.parametrize(
    ('words', 'bad'),
    [
        ('report --problems projectile --quick -o {bad}', 'M\udcfcnchen'),
        ('report --scene {bad} --quick -o {new}', 'M\udcfcnchen.yaml'),
        ('sweep {bad} --vary bodies[0].mass=1,2 -o {new}', 'M\udcfcnchen.yaml'),
    ],
    ids=['report', 'scene of a report', 'scene of a sweep'],
)
def test_a_name_that_is_no_text_is_refused_before_anything_is_run(words, bad, tmp_path, capsys):
    bad, new = tmp_path / bad, tmp_path / 'new'
    if bad.suffix:
        shutil.copy(find_scene('two_bodies'), bad)
    assert main([word.format(bad=bad, new=new) for word in words.split()]) == 2
    said = capsys.readouterr().err
    assert rf'{as_text(str(bad))}: holds bytes that are no text in UTF-8' in said
    assert {*tmp_path.iterdir()} <= {bad} and not bad.is_dir()


@pytest.mark.parametrize('kind', ['bag', 'csv'])
def test_what_is_derived_from_a_name_that_is_no_text_holds_it_as_escapes(kind, tmp_path):
    bad, new = tmp_path / f'M\udcfcnchen.{kind}', tmp_path / 'new'
    if kind == 'csv':
        bad.write_text('time,body,px,py,pz\n' + ''.join(f'{k},ball,0,0,{k}\n' for k in range(9)))
    else:
        good = tmp_path / 'good'
        assert main(['simulate', 'two_bodies', '--duration', '0.1', '-o', str(good)]) == 0
        good.rename(bad)
    assert main(['inverse', str(bad), '-o', str(new)]) == 0
    assert Bag(new).manifest['source'] == rf'M\udcfcnchen.{kind}'


def test_a_path_that_is_no_text_may_lead_to_a_bag(tmp_path):
    folder = tmp_path / 'M\udcfcnchen'
    folder.mkdir()
    bag = str(folder / 'bag')
    assert main(['simulate', 'two_bodies', '--duration', '0.1', '-o', bag]) == 0
    assert main(['replay', bag]) == 0


def no_room(*_arguments):
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def test_a_table_on_a_full_disk_ends_with_1_as_a_run_does(tmp_path, capsys, monkeypatch):
    bag = tmp_path / 'bag'
    assert main(['simulate', 'two_bodies', '--duration', '0.1', '-o', str(bag)]) == 0
    with monkeypatch.context() as patch:
        patch.setattr('os.replace', no_room)
        assert main(['export', str(bag), '-o', str(tmp_path / 'x.csv')]) == 1
    assert 'x.csv: cannot be written: No space left on device; ' in capsys.readouterr().err
    assert main(['export', str(bag), '-o', str(tmp_path / 'none' / 'x.csv')]) == 2
    capsys.readouterr()
    with monkeypatch.context() as patch:
        patch.setattr(McapFile, 'write_chunk', no_room)
        assert main(['inverse', str(bag), '-o', str(tmp_path / 'inv')]) == 1
    assert capsys.readouterr().err == (
        f'rigid_body_sim inverse: error: {tmp_path / "inv"}: writing failed (No space left on '
        'device); nothing in it is of use; make room, remove it, and begin again\n'
    )
