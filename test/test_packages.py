# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Packages are found by the name in package.xml, in every place that ROS users have them."""

import pytest

from armsim_ros.errors import ResourceError
from armsim_ros.packages import package_name, Packages, packages_below


@pytest.fixture
def package(tmp_path, monkeypatch):
    """Return a function that makes a package; nothing is installed, nothing is around."""
    monkeypatch.setenv('AMENT_PREFIX_PATH', '')
    empty = tmp_path / 'empty'
    empty.mkdir()
    monkeypatch.chdir(empty)

    def make(folder, name=None):
        place = tmp_path / folder
        place.mkdir(parents=True)
        (place / 'package.xml').write_text(
            f'<package><!-- <name>commented</name> -->\n <name> {name or place.name} </name>')
        return place

    return make


def test_the_name_is_that_of_the_manifest(package):
    """A package lies in a folder of any name; comments do not count."""
    assert package_name(package('ws/src/panda_description', 'resources_panda')) == \
        'resources_panda'


def test_a_package_of_the_same_workspace_is_found_from_a_file(package, tmp_path):
    """The workspace around the file that the user named is searched, six folders deep."""
    named = package('ws/src/repo/config_package')
    wanted = package('ws/src/a/b/c/d/e/wanted_folder', 'wanted')
    assert Packages(near=[named / 'config' / 'robot.urdf.xacro']).folder('wanted') == wanted
    package('ws/src/a/b/c/d/e/f/too_deep')
    with pytest.raises(ResourceError):
        Packages(near=[named]).folder('too_deep')


def test_the_workspace_around_the_working_folder_counts(package, monkeypatch, tmp_path):
    """Who works in a workspace need not name it."""
    wanted = package('ws/src/wanted')
    (tmp_path / 'ws/src/else').mkdir()
    monkeypatch.chdir(tmp_path / 'ws/src/else')
    assert Packages().folder('wanted') == wanted
    monkeypatch.chdir(tmp_path / 'ws')
    assert Packages().folder('wanted') == wanted


@pytest.mark.parametrize('share', ['install/wanted/share/wanted', 'install/share/wanted'])
def test_an_installation_of_the_workspace_is_found(share, package, tmp_path):
    """Colcon installs merged, or one folder a package."""
    installed = tmp_path / 'ws' / share
    installed.mkdir(parents=True)
    assert Packages(near=[package('ws/src/named')]).folder('wanted') == installed


def test_what_colcon_does_not_see_is_not_found(package, tmp_path):
    """Ignored folders, build results and packages inside packages are none."""
    (package('ws/src/ignored/one').parent / 'COLCON_IGNORE').touch()
    package('ws/src/build/two')
    package('ws/src/.git/three')
    package('ws/src/outer')
    package('ws/src/outer/inner')
    assert set(packages_below(tmp_path / 'ws/src')) == {'outer'}


def test_a_given_folder_wins_over_the_workspace(package, tmp_path):
    """packages_path is looked at first: a package, a tree of packages, an installation."""
    named = package('ws/src/named')
    package('ws/src/wanted')
    given = package('given/repo/wanted')
    assert Packages([tmp_path / 'given'], near=[named]).folder('wanted') == given
    assert Packages([given], near=[named]).folder('wanted') == given


def test_checkouts_beside_each_other_find_each_other(package):
    """Two repositories in one folder need no workspace."""
    named = package('clones/robot_moveit/moveit_config')
    wanted = package('clones/robot/description')
    assert Packages(near=[named / 'config' / 'a.srdf']).folder('description') == wanted


def test_links_that_go_round_in_a_loop_end(package, tmp_path):
    """A link to a folder above it is not followed without end."""
    package('ws/src/repo/wanted')
    (tmp_path / 'ws/src/repo/again').symlink_to(tmp_path / 'ws/src')
    assert set(packages_below(tmp_path / 'ws/src')) == {'wanted'}


def test_a_missing_package_is_answered_with_places_and_remedy(package):
    """The message says where it was looked for, what is nearest, and what to do."""
    named = package('ws/src/panda_description')
    with pytest.raises(ResourceError) as caught:
        Packages(near=[named]).folder('panda_descripton')
    text = str(caught.value)
    assert str(named.parent) in text
    assert "did you mean 'panda_description'?" in text
    assert 'clone it into src/' in text
    assert len(text.splitlines()) == 1


def test_a_package_that_colcon_leaves_out_is_named(package):
    """A missing package that is in the workspace with an ignore mark is told with its folder."""
    named = package('ws/src/here/one')
    ignored = package('ws/src/there/two')
    (ignored / 'COLCON_IGNORE').touch()
    with pytest.raises(ResourceError, match=f'{ignored} is left out of builds by .*COLCON_IGNORE'):
        Packages(near=[named]).folder('two')


def test_all_packages_can_be_listed(package):
    """What is found by name can be listed by name."""
    named = package('ws/src/one')
    other = package('ws/src/two')
    names = Packages(near=[named]).names()
    assert {'one': named, 'two': other}.items() <= names.items()
