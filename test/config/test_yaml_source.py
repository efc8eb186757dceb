"""YAML text to values, and what is said of a text that is none."""

import contextlib
import os
import re

from hypothesis import assume, given, settings
from hypothesis import strategies as st
import pytest
import yaml

from armsim_ros.config.yaml_node import node_of
from armsim_ros.config.yaml_source import LARGEST_FILE, parse_yaml, read_yaml_file
from armsim_ros.errors import ConfigError


def complaint(text):
    """Return the one message about a text."""
    with pytest.raises(ConfigError) as caught:
        parse_yaml(text, 'f.yaml')
    assert len(caught.value.problems) == 1
    return str(caught.value)


def test_values_know_their_line_and_column():
    """Every key and every value has file, line and column."""
    root = parse_yaml('a:\n  b: [1, x]\n', 'f.yaml')
    assert str(root.locate(['a', 'b'])) == 'f.yaml:2:3'
    assert str(root.locate(['a', 'b', 1])) == 'f.yaml:2:10'
    assert root.locate(['a', 'c']) is None


@pytest.mark.parametrize(('text', 'value'), [
    ('1e-3', 0.001), ('1E5', 1e5), ('5.', 5.0), ('.5', 0.5), ('10e-10', 1e-9), ('-3', -3),
    ('0x10', 16), ('.inf', float('inf')), ('-.inf', float('-inf')), ('~', None), ('on', True),
    ('False', False), ('"1"', '1'), ('deg(90)', pytest.approx(1.5707963)),
    ('rad(-pi/2)', pytest.approx(-1.5707963)), ('!degrees 180', pytest.approx(3.1415927)),
    ('1.2.3', '1.2.3'), ('1:30', '1:30'), ('010', 8), ('08', '08'),
])
def test_scalars(text, value):
    """Numbers are read as people write them, 1e-3 too."""
    assert parse_yaml(f'a: {text}', 'f.yaml').plain() == {'a': value}


@pytest.mark.parametrize(('text', 'value'), [
    ('!!float 3', 3.0), ('!!float 3.5', 3.5), ('!!int 3', 3), ('!!bool true', True),
    ('!!str 3', '3'), ('!!null ~', None)])
def test_a_tag_decides_the_type(text, value):
    """Only a float is made of another number."""
    found = parse_yaml(f'a: {text}', 'f.yaml').plain()['a']
    assert (found, type(found)) == (value, type(value))


def test_merge_keys_and_aliases():
    """Aliases repeat a value, '<<' lays blocks over each other, own keys win."""
    text = 'base: &b {x: 1, y: 2}\nother: {<<: *b, y: 3}\nsame: *b\n'
    assert parse_yaml(text, 'f').plain() == {
        'base': {'x': 1, 'y': 2}, 'other': {'x': 1, 'y': 3}, 'same': {'x': 1, 'y': 2}}


@pytest.mark.parametrize(('text', 'message'), [
    ('a: 1\nb: 2\na: 3\n', "f.yaml:3:1: key 'a' is defined twice, first in line 1"),
    ('a:\n\tb: 1\n', 'f.yaml:2:1: the line is indented with a tab; allowed: spaces only'),
    ('- 1\n- 2\n', 'f.yaml:1:1: the file holds a list'),
    ('word\n', "f.yaml:1:1: the file holds the text 'word'"),
    ('a: 1\n---\nb: 2\n', 'f.yaml:2:1: a second document begins here'),
    ('a: [1, 2\nb: 3\n', 'f.yaml:1:4: the bracket that opens here is not closed'),
    ('a: "x\nb: 3\n', 'f.yaml:1:4: the quote that opens here is not closed'),
    ('a: &x [*x]\n', "f.yaml:1:8: '*x' is inside its own value"),
    ('a: *gone\n', "f.yaml:1:4: '*gone' has no anchor"),
    ('a: !!python/object:os.system x\n', "f.yaml:1:4: the tag 'tag:yaml.org,2002:python/object"),
    ('a: deg(x)\n', "f.yaml:1:4: 'x' is not an angle"),
    ('g:\njoints:#mine\n- hip\n', "f.yaml:2: could not find expected ':'; a comment needs"),
    ('l:\n- n: g\na: f type: F\n', 'f.yaml:3:10: mapping values are not allowed in this context'),
    ('joint\uff1a 1\nb: 2\n', "the sign '\uff1a' is not YAML's: write :"),
    ('a: 1\x01\n', 'f.yaml:1:5: the sign 0x01 is not allowed in YAML'),
    ('a: \xe9\x7f\n', 'f.yaml:1:5: the sign 0x7f is not allowed in YAML'),
    (b'a: 1\nb: \xb9\xd8\n', 'f.yaml:2:4: byte 0xb9 is not UTF-8'),
    ('a: 1\n'.encode('utf-16'), 'f.yaml:1: the text is UTF-16'),
    ('[' * 20000, 'f.yaml:1:51: nested more than 50 deep'),
    ('a' * (LARGEST_FILE + 1), 'f.yaml: the file is larger than 1 MiB'),
])
def test_one_message_with_place_and_cause(text, message):
    """A text that is no settings file gives one message that names the line."""
    assert message in complaint(text)


def test_two_keys_on_one_line_are_named_as_the_cause():
    """A line that lost its line break is explained."""
    text = 'controller_list:\n- name: g\naction_ns: f type: F\n'
    assert 'several keys are on the same line' in complaint(text)


def test_an_alias_bomb_is_refused():
    """A text whose aliases expand without end is refused before it is expanded."""
    lines = ['a0: &a0 [x, x, x, x, x, x, x, x, x, x]']
    lines += [f'a{n}: &a{n} [' + ', '.join([f'*a{n - 1}'] * 10) + ']' for n in range(1, 9)]
    assert 'more than 100000 values' in complaint('\n'.join(lines))


def test_a_byte_order_mark_and_an_empty_file_are_fine():
    """What editors add does not matter, and no keys are no mistake."""
    assert parse_yaml(b'\xef\xbb\xbfa: 1', 'f').plain() == {'a': 1}
    assert parse_yaml('# nothing\n', 'f').plain() == {}


def test_a_file_that_is_not_there(tmp_path):
    """A missing file is named."""
    with pytest.raises(ConfigError, match=r'gone\.yaml: cannot be read: No such file'):
        read_yaml_file(tmp_path / 'gone.yaml')


def test_a_pipe_is_refused(tmp_path):
    """Nobody may ever write into it, and the reader would wait."""
    os.mkfifo(tmp_path / 'pipe.yaml')
    with pytest.raises(ConfigError, match=r'pipe\.yaml: cannot be read: it is not a regular file'):
        read_yaml_file(tmp_path / 'pipe.yaml')


_SIGN = st.characters(categories=('L', 'N', 'P')) | st.just(' ')
# 1e3 is a number here, a text to the writer
_WORD = st.text(_SIGN, min_size=1, max_size=5).filter(
    lambda word: not re.search('[0-9.][eE]', word))
_PLAIN = st.recursive(
    st.none() | st.booleans() | st.integers() | _WORD | st.floats(allow_nan=False),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(_WORD, inner, max_size=3),
    max_leaves=8)


@settings(max_examples=80, deadline=None)
@given(st.dictionaries(_WORD, _PLAIN, max_size=4))
def test_what_a_yaml_writer_writes_is_read_back(data):
    """A text from a YAML library gives the values that went in."""
    assume('<<' not in repr(data))
    assert parse_yaml(yaml.safe_dump(data, allow_unicode=True), 'f').plain() == data


@settings(max_examples=150, deadline=None)
@given(st.text(max_size=60) | st.binary(max_size=60))
def test_no_text_breaks_the_reader(data):
    """Whatever the bytes, there are values or a message, and no other exception."""
    with contextlib.suppress(ConfigError):
        assert isinstance(parse_yaml(data, 'f').plain(), dict)


@settings(max_examples=80, deadline=None)
@given(st.dictionaries(_WORD, _PLAIN, max_size=4))
def test_a_value_counts_itself_and_all_values_inside_it(data):
    """The size that bounds aliases counts blocks, lists and scalars, empty ones too."""
    assume('<<' not in repr(data))

    def count(value):
        inner = value.values() if isinstance(value, dict) else value
        return 1 + sum(map(count, inner)) if isinstance(value, (dict, list)) else 1

    read = parse_yaml(yaml.safe_dump(data, allow_unicode=True), 'f')
    assert read.size == node_of(data, read.where).size == count(data)
