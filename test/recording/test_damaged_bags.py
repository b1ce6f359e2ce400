# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Damaged bags: no verb breaks on them, none is called whole that does not replay. The long form is
`tools/damage_bags.py`.
"""

import importlib.util
import json
import os
import struct
import sys
from pathlib import Path

import pytest

from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.recording.plain_yaml import read_yaml
from rigid_body_sim.recording.seal import is_broken, sealed
from rigid_body_sim.terminal import clean_output, printable

TOOL = Path(__file__).parents[2] / 'tools' / 'damage_bags.py'


@pytest.fixture(scope='module')
def tool():
    """
    The attack, as a module.
    """
    spec = importlib.util.spec_from_file_location('damage_bags', TOOL)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules['damage_bags'] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope='module')
def attack(tool, tmp_path_factory):
    """
    An attack on a bag of two bodies with commands.
    """
    scenes = tool.SOURCES[:1]
    return tool.Attack(tmp_path_factory.mktemp('attack'), seed=11, scenes=scenes)


def test_no_verb_breaks_on_a_damaged_bag_and_none_is_called_whole_in_vain(attack):
    attack.run(range(16), ())
    assert not attack.broken
    assert attack.outcomes.total() == 16


def test_a_flipped_bit_is_found_or_changes_nothing_that_is_printed(attack):
    before = attack.outcomes.total()
    attack.run((), range(30))
    assert not attack.broken
    assert attack.outcomes.total() == before + 30


@pytest.mark.parametrize('field', ['sequence', 'log_time', 'publish_time'])
def test_a_replay_finds_another_number_or_time_of_a_message(attack, tool, tmp_path, field):
    parts = tool.records(tool.mcap_of(attack.sources[0]).read_bytes())
    place = {'sequence': 2, 'log_time': 6, 'publish_time': 14}[field]
    at = next(n for n, (opcode, _) in enumerate(parts) if opcode == tool.mcap_file.CHUNK)
    content = bytearray(parts[at][1])
    content[40 + 9 + place] ^= 4  # in the first message of the first chunk
    parts[at] = (parts[at][0], tool.repaired(parts[at][0], bytes(content)))
    (tmp_path / 'other.mcap').write_bytes(tool.packed(parts))
    outcome = tool.call('replay', tmp_path / 'other.mcap')
    assert outcome.code in (2, 3), outcome
    assert tool.call('bag', 'check', tmp_path / 'other.mcap').code == 1


@pytest.mark.parametrize(
    'key', ['energy_drift', 'energy_history', 'state_chain_sha256', 'ticks', 'last_time_ns']
)
def test_a_replay_derives_the_ending_anew(tool, tmp_path, key):
    assert tool.call('simulate', 'oscillator', '-o', tmp_path / 'run', '--duration', 1).code == 0
    file = tool.mcap_of(tmp_path / 'run')
    parts = tool.records(file.read_bytes())
    (at,) = [
        n
        for n, (opcode, content) in enumerate(parts)
        if opcode == tool.mcap_file.METADATA and b'end_reason' in content
    ]
    name, pairs = tool.metadata(parts[at][1])
    history = json.loads(pairs['energy_history'])
    history['change'][-1] += 0.5  # [J] of a swing of 5 J
    pairs[key] = {
        'energy_drift': '0.25',
        'energy_history': json.dumps(history),
        'state_chain_sha256': 64 * '0',
    }.get(key, '12')
    parts[at] = (parts[at][0], tool.metadata_content(name, sealed(pairs)))
    file.write_bytes(tool.packed(parts))
    outcome = tool.call('replay', file)
    assert outcome.code == 3
    assert key.removesuffix('_sha256').replace('_', ' ') in outcome.out


@pytest.mark.parametrize('gone', ['end of a chunk', 'ending record'])
def test_what_is_saved_of_an_altered_bag_is_not_called_whole(attack, tool, tmp_path, gone):
    """
    A bit of a pose is another, and the CRC of its chunk is right again. No cut leaves a chunk with
    a right CRC that ends within a record, nor a file with its end and no ending: the message
    before is not to be trusted either, also when the copy is copied.
    """
    parts = tool.records(tool.mcap_of(attack.sources[0]).read_bytes())
    *_, at = (n for n, (opcode, _) in enumerate(parts) if opcode == tool.mcap_file.CHUNK)
    content = bytearray(parts[at][1])
    (length,) = struct.unpack_from('<Q', content, 41)
    content[40 + 9 + length - 10] ^= 1
    if gone == 'end of a chunk':
        del content[-5:]
        for place in (16, 32):
            struct.pack_into('<Q', content, place, len(content) - 40)
    parts[at] = (parts[at][0], tool.repaired(parts[at][0], bytes(content)))
    if gone == 'ending record':
        parts = [part for part in parts if b'end_reason' not in part[1]]
    (tmp_path / 'altered.mcap').write_bytes(tool.packed(parts))
    source = tmp_path / 'altered.mcap'
    for copy in ('saved', 'saved again'):
        assert tool.call('bag', 'recover', source, '-o', tmp_path / copy).code == 0
        source = tmp_path / copy
        outcome = tool.call('bag', 'check', source)
        assert outcome.code == 1 and 'not as it was recorded' in outcome.out, outcome


def test_a_seal_shows_any_change():
    content = sealed({'a': '1', 'b': '2'})
    assert not is_broken(content)
    assert not is_broken({'a': '1'}), 'older records have none'
    for key in content:
        assert is_broken({**content, key: content[key] + ' '})
    assert is_broken({**content, 'c': ''})


@pytest.mark.parametrize(
    'text',
    ['a: &a 1\nb: *a', 'a: &a {x: 1}\nb: {<<: *a}', '[' * 40 + ']' * 40, 'a: [', '1e400: {}\n? ['],
)
def test_yaml_that_could_cost_more_than_its_length_is_refused(text):
    with pytest.raises(ValueError, match=r'\w'):
        read_yaml(text)


def test_names_reach_the_terminal_as_text(capsys):
    assert printable('a\x1b[2J\u202eb\n') == 'a\\x1b[2J\\u202eb\\n'
    assert printable('Füße … µ') == 'Füße … µ'
    with clean_output():
        print('\rbar\x1b[2J')
        print('line\u2028two\tthree')
    assert capsys.readouterr().out == '\rbar\\x1b[2J\nline\\u2028two\tthree\n'


def test_what_is_no_regular_file_is_not_waited_for(tool, tmp_path):
    os.mkfifo(tmp_path / 'pipe')
    for verb in (('bag', 'info'), ('bag', 'check'), ('replay',)):
        for path in (tmp_path / 'pipe', Path('/dev/zero'), tmp_path / ('x' * 300)):
            outcome = tool.call(*verb, path, limit=5)
            assert (outcome.code, outcome.err.count('\n')) == (2, 1), outcome


def test_older_bags_without_seals_are_read(record, monkeypatch):
    monkeypatch.setattr('rigid_body_sim.recording.bag_writer.sealed', dict)
    bag = Bag(record())
    assert bag.manifest['integrator'] == 'dmv6'
