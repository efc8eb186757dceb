"""The same parameters, however a file of ROS 2 nests, dots and addresses them."""

from hypothesis import given, settings
from hypothesis import strategies as st
import yaml

from armsim_ros.config.draft import ConfigDraft
from armsim_ros.config.layout import LayoutReader
from armsim_ros.config.yaml_source import parse_yaml

words = st.sampled_from(['a', 'joint_1', 'p', 'goal', 'constraints', 'x2'])
scalars = st.one_of(
    st.integers(-5, 5), st.booleans(), st.floats(-9, 9), st.lists(words, max_size=3))
parameters = st.recursive(
    st.dictionaries(words, scalars, min_size=1, max_size=3),
    lambda inner: st.dictionaries(words, st.one_of(scalars, inner), min_size=1, max_size=3))


def read(text):
    """Return the controllers of a file and their namespaces."""
    draft = ConfigDraft()
    LayoutReader(draft).read(parse_yaml(text, 'f.yaml'), 'controllers')
    assert not draft.problems
    return draft.section('controllers').plain(), set(draft.namespaces)


@st.composite
def spellings(draw, values):
    """Draw the same parameters with some of their blocks written as dotted keys."""
    spelled = {}
    for key, value in values.items():
        if not isinstance(value, dict):
            spelled[key] = value
        elif draw(st.booleans()):
            spelled[key] = draw(spellings(value))
        else:
            for name, inner in draw(spellings(value)).items():
                spelled[f'{key}.{name}'] = inner
    return spelled


@settings(deadline=None)
@given(st.data(), parameters)
def test_the_spelling_of_a_file_does_not_matter(data, values):
    """Nested or dotted keys, a namespace in the node's name or as a block: equal parameters."""
    spelled = {'ros__parameters': data.draw(spellings(values))}
    address, namespace = data.draw(st.sampled_from([
        ('arm', ''), ('/arm', ''), ('/**/arm', ''), ('/ns/arm', 'ns'), ('ns/arm', 'ns')]))
    file = {address: spelled}
    if namespace and data.draw(st.booleans()):
        file = {namespace: {'arm': spelled}}
    found, namespaces = read(yaml.safe_dump(file))
    assert found == {'arm': values}
    assert namespaces == {namespace}


@settings(deadline=None)
@given(st.data(), parameters, parameters)
def test_a_node_by_name_wins_over_a_wildcard(data, common, own):
    """A node in any namespace gives what the node of that name does not set itself."""
    file = {'/**/arm': {'ros__parameters': {'common': 1, **common}},
            '/arm': {'ros__parameters': {'own': 2, **own}}}
    order = data.draw(st.permutations(list(file)))
    found, _ = read(yaml.safe_dump({name: file[name] for name in order}, sort_keys=False))
    assert found == {'arm': merged({'common': 1, **common}, {'own': 2, **own})}


def merged(common, own):
    """Return parameters of both, block by block; the own value wins."""
    both = {**common, **own}
    for key in set(common) & set(own):
        if isinstance(common[key], dict) and isinstance(own[key], dict):
            both[key] = merged(common[key], own[key])
    return both
