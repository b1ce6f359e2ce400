# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
metadata.yaml is composed of texts that are written once for each type of topic: what comes out is
what PyYAML writes of the whole map.
"""

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from rigid_body_sim.recording import bag_metadata
from rigid_body_sim.recording.bag_metadata import (
    Information,
    TopicSummary,
    _read_item_by_item,
)
from rigid_body_sim.recording.plain_yaml import read_yaml
from rigid_body_sim.recording.topics import qos_text

ROOT = 'rosbag2_bagfile_information'
NAMES = st.one_of(
    st.from_regex(r'(/[A-Za-z0-9_]{1,40}){1,4}', fullmatch=True),
    st.sampled_from(
        ['/', '/a: b', "/it's", '~', 'null', '/a #b', '', '/é', '- x', '/1:30', 'x\ny']
    ),
    st.text(alphabet=st.characters(codec='utf-8', exclude_categories=['C']), max_size=60),
)
TOPICS = st.builds(
    TopicSummary,
    name=NAMES,
    type=st.sampled_from(['geometry_msgs/msg/PoseStamped', 'rosgraph_msgs/msg/Clock', 'name: /x']),
    encoding=st.just('cdr'),
    qos=st.sampled_from([qos_text(), '', 'no: [list', '- depth: 3\n']),
    hash=st.sampled_from(['RIHS01_0a1b', '', '0']),
    messages=st.integers(0, 2**40),
)
INFORMATION = st.builds(
    Information,
    file_name=st.sampled_from(['bag_0.mcap', ': ' * 60 + '_0.mcap', '010', 'a long name ' * 12]),
    topics=st.lists(TOPICS, max_size=4),
    first_time=st.integers(0, 2**40),
    last_time=st.integers(2**40, 2**62),
    custom=st.dictionaries(st.sampled_from(['a', 'b b', '1']), st.text(max_size=90), max_size=2),
)


class _Plain(getattr(yaml, 'CSafeDumper', yaml.SafeDumper)):
    def ignore_aliases(self, data):
        return True


def written(content):
    """
    What PyYAML writes.
    """
    return yaml.dump(content, Dumper=_Plain, sort_keys=False, default_flow_style=False)


@settings(max_examples=60, deadline=None)
@given(INFORMATION)
def test_what_is_composed_is_what_pyyaml_writes_of_the_whole(information):
    inner = information.text()
    content = read_yaml(inner)
    assert inner == written(content)
    assert [
        (each['topic_metadata']['name'], each['message_count'])
        for each in content['topics_with_message_count']
    ] == [(topic.name, topic.messages) for topic in information.topics]
    assert content['message_count'] == sum(topic.messages for topic in information.topics)
    assert content['custom_data'] == information.custom
    whole = information.file_text()
    assert read_yaml(whole) == {ROOT: content}
    if not any('\n' in topic.name or ' ' in topic.name for topic in information.topics):
        assert whole == written({ROOT: content})  # a long name folds elsewhere at another depth


def test_a_topic_more_is_its_own_lines_more_and_no_other():
    def lines(count):
        topics = [
            TopicSummary(
                f'/b_{i}/pose', 'geometry_msgs/msg/PoseStamped', 'cdr', qos_text(), 'h', 7
            )
            for i in range(count)
        ]
        return Information('x_0.mcap', topics, 0, 1, {}).file_text().splitlines()

    one, two = lines(1), lines(2)
    start = one.index('  - topic_metadata:')
    item = len(two) - len(one)
    again = two[start + item : start + 2 * item]
    assert [line.replace('b_1', 'b_0') for line in again] == two[start : start + item]


@pytest.mark.parametrize(
    'text',
    [
        'a: 1\na: 2\n',
        '[1, 010, 0x1f, 1_0, 1.5, yes, ~, 2001-01-01, .inf, 1e3, "1", null, =]',
        'a: &x [1]\n',
        'b: !!str 1\n',
        'a: {<<: {b: 1}}\n',
        '{1: 2, [1]: 3}\n',
        '',
        'x',
        'a: |\n  text\n  more\nb: >\n  folded\n',
        '--- 1\n',
    ],
)
def test_one_pass_reads_what_the_loader_reads(text):
    try:
        expected = yaml.safe_load(text)
    except (yaml.YAMLError, TypeError):
        expected = None
    try:
        found = read_yaml(text)
    except ValueError:
        found = None
    assert repr(found) == repr(expected)


@pytest.mark.parametrize(
    'text', ['a: &x [1]\nb: *x\n', '[' * 40 + ']' * 40, '--- 1\n--- 2\n', '{a']
)
def test_what_metadata_never_holds_is_refused(text):
    with pytest.raises(ValueError, match=r'alias|nested|single document|expected'):
        read_yaml(text)


def read_whole(text):
    """
    What a reader makes of the whole text, or what it says.
    """
    try:
        return read_yaml(text)
    except ValueError as error:
        return str(error)


@settings(max_examples=150, deadline=None)
@given(INFORMATION, st.randoms(use_true_random=False), st.integers(0, 3))
def test_read_item_by_item_it_is_what_it_is_as_a_whole(information, draw, changes):
    letters = [*information.file_text()]
    for _ in range(changes):
        place = draw.randrange(len(letters))
        letters[place : place + draw.randrange(2)] = draw.choice('\'":#&*!|>-[]{},? \n\ta0~%@`')
    text = ''.join(letters)
    found = _read_item_by_item(text)
    assert found is None or repr(found) == repr(read_whole(text))


def test_what_all_topics_of_a_type_have_in_common_is_read_once(monkeypatch):
    topics = [
        TopicSummary(f'/b{n}/pose', 'geometry_msgs/msg/PoseStamped', 'cdr', qos_text(), 'h', n)
        for n in range(100)
    ]
    text = Information('bag_0.mcap', topics, 0, 1, {}).file_text()
    lengths = []
    monkeypatch.setattr(
        bag_metadata, 'read_yaml', lambda part: (lengths.append(len(part)), read_yaml(part))[1]
    )
    assert _read_item_by_item(text) == read_yaml(text)
    assert sum(lengths) < len(text) / 20
