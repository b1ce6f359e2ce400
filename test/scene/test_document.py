# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The text of a scene is read straight from the parser's events and written without an emitter: both
are what PyYAML's own long ways give, value for value and byte for byte.
"""

import math

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.model.rotation import normalise, normalised
from rigid_body_sim.scene import document

from ..inside import values_by_nodes, yaml_by_emitter

WORDS = ['name', 'box', 'yes', 'No', 'null', '~', 'true', 'y', 'on', '1e-3', '010', '0x1F', '1_0']
WORDS += ['1:30', '.5', '5.', '+3', '-0', '-0.0', '1.5e+3', '1.e5', '.inf', '-.INF', '.nan', '=']
WORDS += ['<<', '2001-01-01', '1' * 20, '1' * 400, '', ' ', 'a b', "it's", 'a: b', '- x', '#', 'é']
WORDS += [
    'meshes/a.stl',
    'a-b',
    'v1.0',
    'a' * 200,
    'x\ny',
    '0b11',
    '0o7',
    '1e400',
    '12.0e-7',
    '!x',
]
NUMBERS = st.one_of(st.floats(), st.integers(-(10**25), 10**25))
SCALARS = st.one_of(st.sampled_from(WORDS), NUMBERS, st.none(), st.booleans(), st.text(max_size=9))
TREES = st.recursive(
    SCALARS,
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.lists(inner, max_size=2).map(tuple)
        | st.dictionaries(st.sampled_from(WORDS) | st.integers(0, 3), inner, max_size=4)
    ),
    max_leaves=20,
)
MAPPINGS = st.dictionaries(st.sampled_from(WORDS), TREES, max_size=4)
LINES = st.lists(
    st.sampled_from(
        ['a: ', 'b:\n', '  c: ', '- ', '  - ', '{', '}', '[', ']', ', ', '\n', '? ', '|\n']
    )
    | st.sampled_from(WORDS)
    | st.sampled_from(
        ['&k ', '*k', '!!int ', '!!str ', '<<: ', '"q"', "'s'", '---\n', '...\n', '"a": ']
    ),
    max_size=14,
)


def told(read, text):
    """
    What a reader says of a text: its values with their types, or the refusal.
    """
    try:
        return repr(read(text))
    except (UserError, yaml.YAMLError, ValueError, KeyError, AttributeError, TypeError) as error:
        return type(error)


def by_both(text):
    """
    What is read of a text, and what PyYAML's tree gives: None where it gives a refusal.
    """
    long_way = told(values_by_nodes, text)
    short_way = told(lambda t: document.read(t, name='x').content, text)
    refused = isinstance(long_way, type)
    return (None if short_way is UserError else short_way), (None if refused else long_way)


@pytest.mark.parametrize('draws', [20, pytest.param(150, marks=pytest.mark.long)])
def test_values_come_out_as_from_the_tree_of_nodes(draws):
    @settings(max_examples=draws)
    @given(MAPPINGS, st.booleans())
    def holds(content, flow):
        text = yaml.safe_dump(content, default_flow_style=flow).encode()
        short, long = by_both(text)
        assert short == long

    holds()


@settings(max_examples=300, deadline=None)
@given(LINES)
def test_whatever_is_written_is_read_or_refused_as_by_the_tree(parts):
    short, long = by_both(''.join(parts).encode())
    assert short == long


@pytest.mark.parametrize('word', WORDS)
def test_a_plain_word_means_what_it_means_to_the_tree(word):
    for text in (word, f'- {word}', f'{{a: {word}, b: {word}}}'):
        short, long = by_both(text.encode())
        assert short == long


@pytest.mark.parametrize(
    ('text', 'said'),
    [
        ('a: 1\nb: 2\na: 3\n', 'stands twice in one mapping'),
        ('{a: {"b": 1, b: 2}}', 'stands twice in one mapping'),
        ('[' * 40 + ']' * 40, 'nested more than'),
        ('a: [1, 2\nb: 3\n', 'line 2'),
        ('a: &k [1]\nb: *n\n', 'undefined alias'),
    ],
)
def test_a_fault_is_told_by_the_tree(text, said):
    with pytest.raises(UserError, match=said):
        document.read(text.encode(), name='x')


def test_more_values_than_the_memory_should_hold_are_refused(monkeypatch):
    monkeypatch.setattr(document, 'MOST_VALUES', 50)
    assert document.read(f'[{", 1" * 0}{"1, " * 49}]'.encode(), name='x').content == [1] * 49
    with pytest.raises(UserError, match='more than 50 values'):
        document.read(f'[{"1, " * 50}]'.encode(), name='x')


def test_lines_are_those_of_the_text():
    text = b'a: 1\nbodies:\n  - name: x\n    mass: &m 2\n  - {name: y,\n     mass: 3}\n'
    read = document.read(text, name='x')
    assert read.line(('bodies', 0, 'mass')) == 4
    assert read.line(('bodies', 1, 'mass')) == 6
    assert read.line(('bodies', 7, 'mass')) == 3


@pytest.mark.parametrize('draws', [60, pytest.param(200, marks=pytest.mark.long)])
def test_a_mapping_is_written_as_pyyaml_writes_it(draws):
    settings(max_examples=draws)(given(MAPPINGS)(_is_written_as_pyyaml_writes_it))()


def _is_written_as_pyyaml_writes_it(content):
    try:
        expected = yaml_by_emitter(content)
    except yaml.YAMLError:
        return
    assert document.write(content) == expected


def test_numpy_values_are_written_as_plain_ones():
    content = {
        'a': np.arange(6.0).reshape(2, 3),
        'b': [np.float64(0.1), np.int32(3), np.bool_(True), np.array(2.5), np.array([])],
        'c': {'d': (1, [2, [3.0, []]], {}), 'e': -1e-300},
    }
    assert document.write(content) == yaml_by_emitter(content)


@settings(max_examples=300, deadline=None)
@given(st.lists(st.floats(-1e300, 1e300), min_size=4, max_size=4), st.integers(-300, 0))
def test_one_quaternion_is_normalised_to_the_bits_of_many(values, exponent):
    values = [math.ldexp(value, exponent) for value in values]
    try:
        expected = tuple(normalise(values).tolist())
    except ValueError as error:
        with pytest.raises(ValueError, match=str(error)[:20]):
            normalised(values)
    else:
        assert normalised(values) == expected


@pytest.mark.parametrize(
    ('text', 'told'),
    [
        (b'dt: 0.01\nbodies:\n\t- {name: a}\n', 'line 3, column 1: a tab, and YAML indents by '),
        (b'bodies:\n- name: a\n\tmass: 1\n', 'line 3, column 1: a tab, and YAML indents by '),
        (
            b'name: M\xfcnchen\n',
            "line 1: the byte 0xFC is no text in UTF-8 (in Latin-1 '\u00fc'); ",
        ),
        (b'dt: 1\nname: a\x07b\n', r"line 2: holds '\x07', which controls and shows nothing; "),
    ],
)
def test_what_editors_leave_in_a_text_is_told_with_its_line_and_cure(text, told):
    with pytest.raises(UserError) as refused:
        document.read(text, name='a.yaml')
    assert str(refused.value).startswith(f'a.yaml: {told}')
