# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which pairs may touch."""

import pytest

from armsim_ros.errors import PlanningError
from armsim_ros.planning.scene.allowed_collision_matrix import AcmUpdate, AllowedCollisionMatrix


def test_srdf_disables_pairs_and_nothing_else(make_robot):
    """SCN-12: neighbours are only exempt when the SRDF says so."""
    acm = AllowedCollisionMatrix.from_robot(make_robot([('upper', 'fore')]))
    assert acm.allowed('upper', 'fore')
    assert acm.allowed('fore', 'upper')
    assert not acm.allowed('base', 'upper')


def test_enabled_pairs_win_over_defaults(make_robot):
    """SCN-12: disable_default_collisions allows a link all, enable_collisions takes it back."""
    acm = AllowedCollisionMatrix.from_robot(make_robot(
        [('upper', 'fore')],
        default_disabled=frozenset({'finger'}),
        enabled_collisions=frozenset({('base', 'finger')}),
    ))
    assert acm.allowed('finger', 'upper')
    assert acm.allowed('finger', 'any object')
    assert not acm.allowed('finger', 'base')


def test_a_pair_both_enabled_and_disabled_is_disabled(make_robot):
    """What the SRDF disables is set last (upstream's collision_matrix.cpp, the constructor)."""
    acm = AllowedCollisionMatrix.from_robot(make_robot(
        [('upper', 'fore')],
        default_disabled=frozenset({'fore'}),
        enabled_collisions=frozenset({('fore', 'upper'), ('base', 'fore')}),
    ))
    assert acm.allowed('upper', 'fore')
    assert not acm.allowed('base', 'fore')


def test_neighbours_are_exempt_where_the_srdf_is_silent(make_robot):
    """SCN-12: an SRDF without any disabled pair would make every state collide."""
    acm = AllowedCollisionMatrix.from_robot(make_robot())
    assert acm.allowed('base', 'upper')
    assert acm.allowed('fore', 'finger')
    assert not acm.allowed('base', 'fore')
    strict = AllowedCollisionMatrix.from_robot(make_robot(), auto_disable_adjacent=False)
    assert not strict.allowed('base', 'upper')


def test_only_the_upper_triangle_is_read():
    """SCN-13: where the halves differ the upper one wins."""
    acm = AllowedCollisionMatrix.from_update(
        AcmUpdate(('a', 'b', 'c'), ((False, True, False), (False, False, False),
                                    (True, True, False))))
    assert acm.allowed('b', 'a')
    assert not acm.allowed('a', 'c')
    assert not acm.allowed('b', 'c')


def test_defaults_apply_without_an_explicit_pair():
    """SCN-13: a pair's own entry wins; both defaults must allow."""
    acm = AllowedCollisionMatrix().with_default('a', True).with_default('b', False)
    assert acm.allowed('a', 'x')
    assert not acm.allowed('a', 'b')
    assert acm.with_pair('b', 'a', True).allowed('a', 'b')
    assert not acm.with_pair('a', 'x', False).allowed('x', 'a')


def test_names_need_not_exist():
    """SCN-13: an entry may speak of objects to come."""
    acm = AllowedCollisionMatrix().with_pair('cup', 'table', True)
    assert acm.allowed('table', 'cup')
    assert acm.names == ('cup', 'table')


def test_entry_sets_all_pairs_of_a_name():
    """PM-8: an object that may touch everything known."""
    acm = AllowedCollisionMatrix(names=('a', 'b')).with_entry('cup', True)
    assert acm.allowed('cup', 'a')
    assert acm.allowed('b', 'cup')
    assert not acm.allowed('a', 'b')


def test_message_and_back_is_the_same(make_robot):
    """SRV-50: the matrix that a client reads is the one that holds."""
    acm = AllowedCollisionMatrix.from_robot(
        make_robot([('upper', 'fore')], default_disabled=frozenset({'finger'}))
    ).with_pair('finger', 'base', False)
    again = AllowedCollisionMatrix.from_update(acm.to_update())
    names = [*acm.names, 'unknown']
    for one in names:
        for other in names:
            if one != other:
                assert again.allowed(one, other) == acm.allowed(one, other)
    assert set(again.names) == set(acm.names)


def test_names_of_a_message_are_sorted_and_defaults_hold_for_a_name_itself():
    """As upstream's AllowedCollisionMatrix::getMessage writes them."""
    update = AllowedCollisionMatrix(names=('b',)).with_default('c', True).with_pair(
        'b', 'a', True).to_update()
    assert update.entry_names == ('a', 'b', 'c')
    assert update.entry_values == ((False, True, True), (True, False, True), (True, True, True))
    assert (update.default_entry_names, update.default_entry_values) == (('c',), (True,))


def test_without_forgets_the_pairs_of_a_name():
    """SCN-5: those of a removed object go."""
    acm = AllowedCollisionMatrix().with_pair('cup', 'a', True)
    assert not acm.without(['cup']).allowed('cup', 'a')
    assert acm.without(['cup']).names == ('a',)
    assert acm.without(['other']) is acm


def test_a_default_outlives_its_object():
    """It holds for the next object of that name; collision_matrix.cpp, removeEntry."""
    acm = AllowedCollisionMatrix().with_default('cup', True).with_pair('cup', 'a', False)
    without = acm.without(['cup'])
    assert without.allowed('cup', 'a')
    assert without.to_update().default_entry_names == ('cup',)
    assert without.without(['cup']) is without


def test_without_unknown_names_reads_no_pair():
    """An edit that takes no known name away costs the same however many pairs there are."""
    class Unread(dict):
        def __iter__(self):
            raise AssertionError('the pairs are read')

        items = __iter__

    acm = AllowedCollisionMatrix(Unread({('a', 'b'): True}), {}, ('a', 'b'))
    assert acm.without(()) is acm
    assert acm.without(['other']) is acm


def test_a_pair_without_an_entry_follows_the_defaults():
    """Its names stay known; a pair that has none is no change."""
    acm = AllowedCollisionMatrix().with_pair('b', 'a', False).with_default('a', True)
    without = acm.without_pair('a', 'b')
    assert without.allowed('a', 'b')
    assert set(without.names) == {'a', 'b'}
    assert without.without_pair('b', 'a') is without


@pytest.mark.parametrize('update', [
    AcmUpdate(('a', 'b'), ((True, True),)),
    AcmUpdate(('a', 'b'), ((True, True), (True,))),
    AcmUpdate((), ((True,),)),
    AcmUpdate(('a',), ((True,),), ('x', 'y'), (True,)),
])
def test_message_that_does_not_fit_is_refused(update):
    """SCN-13a: numbers of names and values must agree."""
    with pytest.raises(PlanningError, match='allowed collision matrix'):
        AllowedCollisionMatrix.from_update(update)


def test_pairs_that_another_matrix_forgets():
    """Only allowed pairs of the given names count, and those of which a name is not known."""
    def matrix(*pairs):
        return AllowedCollisionMatrix().with_pairs(dict.fromkeys(pairs, True))

    before = matrix(('a', 'b'), ('b', 'c'), ('c', 'box')).with_pair('a', 'd', False)
    assert before.forgotten_by(before, 'abcd') == []
    assert before.forgotten_by(matrix(('a', 'c')), 'abcd') == [('a', 'b'), ('b', 'c')]
    assert before.forgotten_by(matrix(('a', 'b'), ('c', 'd')), 'abcd') == []
