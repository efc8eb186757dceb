# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What whoever tests an arm by the pytest plugin may rely on."""

import re
import sys

import pytest

statement = pytest.mark.statement

FIRST_TEST = """
import pytest
from armsim_ros.testing import assert_no_collision, assert_reached


@pytest.mark.armsim(robot='sunday')
def test_reaches_scan_food(arm):
    arm.move_to('scan_food')
    assert_reached(arm, 'scan_food')
    assert_no_collision(arm)
"""

PASSING = """
    import pytest
    from armsim_ros.testing import assert_reached

    pytestmark = pytest.mark.armsim(robot='bot')
    DIGESTS = []

    @pytest.mark.armsim(robot='sunday')
    def test_moves_and_spawns(arm):
        DIGESTS.append(arm.digest())
        arm.spawn('box', xyz=(1.0, 0.0, 0.5), mass=0.2)
        arm.move_to('scan_food')

    @pytest.mark.armsim(robot='sunday')
    def test_starts_anew(arm):
        DIGESTS.append(arm.digest())
        assert_reached(arm, 'home')
        assert len(set(DIGESTS)) == 1

    def test_seed(arm):
        print('seed of the arm', arm.seed)

    @pytest.mark.armsim(seed=3)
    class TestMarkers:

        @pytest.mark.armsim(seed=4)
        def test_both(self, arm):
            assert arm.name == 'bot'
            assert arm.seed == 4

    @pytest.mark.armsim(robot='sunday', **{'simulation.gravity': [0, 0, 0]})
    def test_weightless(arm):
        assert arm.name == 'sunday'
        arm.spawn('ball', xyz=(1.0, 0.0, 2.0), mass=0.1)
        arm.wait(0.5)
        assert abs(arm.entity('ball')[2, 3] - 2.0) < 1e-9
"""


@pytest.fixture(scope='module')
def first_test(run_file):
    """Return what came of a test that a stranger writes first."""
    return run_file(FIRST_TEST)


@pytest.fixture(scope='module')
def passing(run_file):
    """Return what came of more tests, all of which are to leave a recording."""
    return run_file(PASSING, '--armsim-seed=random', '-s', '--armsim-keep',
                    '--armsim-artifacts=kept')


@statement('G1', 'G10')
def test_a_file_of_ten_lines_needs_no_conftest(first_test):
    """A folder with nothing but a test of ten lines is green."""
    assert first_test.outcome('test_reaches_scan_food') == 'passed'


@statement('G2')
def test_the_nearest_marker_wins_word_by_word(passing):
    """Words of a test's marker win over those of its class and module, the others stay."""
    assert passing.outcome('TestMarkers::test_both') == 'passed'
    assert passing.outcome('test_weightless') == 'passed'


@statement('G2')
def test_settings_are_overridden_by_dotted_words(passing):
    """A dotted word of the marker goes over the robot's files."""
    assert passing.outcome('test_weightless') == 'passed'


@statement('G4')
def test_every_test_starts_from_the_same_state(passing):
    """What a test does to arm and world is not there in the next one."""
    assert passing.outcome('test_moves_and_spawns') == 'passed'
    assert passing.outcome('test_starts_anew') == 'passed'


@statement('G3')
def test_the_same_test_ends_in_the_same_digest(new_arm):
    """Equal seeds and calls give equal digests, another seed plans another way."""
    digests = []
    for _ in range(2):
        arm = new_arm()
        arm.move_to('scan_face')
        arm.wait(0.1)
        digests.append(arm.digest())
    assert digests[0] == digests[1]


@statement('G3')
def test_a_trajectory_is_followed(new_arm):
    """Points by joint, or in the order of the planning group, are run as they are."""
    arm = new_arm()
    arm.follow([(0.5, dict.fromkeys(arm.joints, 0.1)), (1.0, dict.fromkeys(arm.joints, 0.2))])
    arm.follow([(1.0, [0.0] * 6)])
    joint, error = arm.distance(dict.fromkeys(arm.joints, 0.0))
    assert abs(error) < 1e-3, joint


@statement('G6')
def test_the_worst_joint_is_named(new_arm):
    """assert_reached names joint, distance, tolerance and simulated time."""
    from armsim_ros.testing import assert_reached

    arm = new_arm()
    arm.wait(0.25)
    with pytest.raises(AssertionError, match=r"'scan_food'.*'joint_5' is -1\.57.*tolerance 0\.001"
                                             r', at 0\.250 s'):
        assert_reached(arm, 'scan_food')


@statement('G6')
def test_a_collision_names_bodies_depth_and_time(new_arm):
    """assert_no_collision tells which link touched what, how deep and when."""
    from armsim_ros.testing import assert_no_collision, assert_no_contact

    arm = new_arm()
    assert_no_collision(arm)
    arm.spawn('wall', (0.3, 0.02, 0.6), xyz=(0.2, 0.0, 1.6))
    arm.follow([(0.5, [1.5, 0.0, 0.0, 0.0, 0.0, 0.0])])
    with pytest.raises(AssertionError, match=r'sunday/link_\d.*object/wall.*mm from 0\.\d+ to'):
        assert_no_collision(arm)
    with pytest.raises(AssertionError, match="'wall' was touched"):
        assert_no_contact(arm, 'wall')
    assert_no_contact(arm, 'picture')
    assert_no_collision(arm, since=arm.time + 1.0)


@statement('G6')
def test_a_refusal_is_expected_and_its_reason_read(new_arm):
    """assert_rejected returns the controllers' reason, and fails where the arm obeys."""
    from armsim_ros.testing import assert_rejected

    arm = new_arm()
    backwards = [(1.0, [0.1] * 6), (0.5, [0.2] * 6)]
    assert 'not after the 1 s of point 0' in assert_rejected(arm, backwards, 'point 1')
    assert 'point 0' in assert_rejected(arm, [(1.0, [0.1] * 5)])
    with pytest.raises(AssertionError, match='should have been refused'):
        assert_rejected(arm, [(0.5, [0.0] * 6)])


@statement('G7')
def test_a_test_that_passed_leaves_nothing(first_test, passing):
    """Only failed tests write files, unless they are all to be kept."""
    assert not (first_test.folder / 'armsim-artifacts').exists()
    assert list((passing.folder / 'kept').glob('*.mcap'))


@statement('G8')
def test_a_random_seed_is_printed_and_can_be_given(passing):
    """--armsim-seed=random chooses a seed, tells it in the header, and gives it to the arm."""
    told = re.search(r'armsim: --armsim-seed=(\d+)', passing.text)[1]
    assert f'seed of the arm {told}' in passing.text


@statement('G8')
@pytest.mark.parametrize('option', ['--armsim-mode=real', '--armsim-seed=x'])
def test_a_wrong_option_is_a_usage_error(run_tests, option):
    """Options are checked before any test runs."""
    result = run_tests(FIRST_TEST, option)
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    assert option in result.stderr.str()


def test_the_plugin_is_found_by_its_entry_point():
    """The installed package announces the plugin to pytest."""
    from importlib.metadata import entry_points

    found = {point.name: point.value for point in entry_points(group='pytest11')}
    assert found['armsim'] == 'armsim_ros.testing.plugin'
    assert 'armsim_ros.testing.plugin' in sys.modules
