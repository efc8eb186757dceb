# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What whoever tests an arm by the pytest plugin may rely on."""

from pathlib import Path
import re
import signal
import sys
import threading
import time

from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
import pytest

from armsim_ros.testing.programs.program import Program

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

BLOCKED = """
import pytest
from armsim_ros.testing import assert_reached

JOINTS = ('joint_1', 'joint_2', 'joint_3', 'joint_4', 'joint_5', 'joint_6')


@pytest.mark.armsim(faults={'joint_1': {'blocked': True}})
def test_turns(arm):
    arm.follow([(1.0, dict.fromkeys(JOINTS, 0.3))])
    assert_reached(arm, dict.fromkeys(JOINTS, 0.3))
"""


@statement('G1', 'G10')
def test_a_file_of_ten_lines_needs_no_conftest(run_tests):
    """A folder with nothing but a test of ten lines is green."""
    run_tests(FIRST_TEST).assert_outcomes(passed=1)


@statement('G1')
def test_the_plugin_imports_nothing_of_weight(run_tests):
    """A test that asks for no arm imports neither MuJoCo nor rclpy nor numpy."""
    result = run_tests("""
        import sys

        def test_light():
            heavy = {'mujoco', 'rclpy', 'numpy', 'pydantic', 'coal', 'ompl'}
            assert not heavy & set(sys.modules)
    """)
    result.assert_outcomes(passed=1)


@statement('G2')
@pytest.mark.parametrize(('words', 'complaint'), [
    ("robt='sunday'", "did you mean 'robot'?"),
    ("mode='gazebo'", 'allowed: inprocess, process'),
    ('time_limit=0', 'must be above 0'),
    ("robot='sundy'", "did you mean 'sunday'?"),
    ("faults={'joint_9': {'blocked': True}}", "joint 'joint_9'"),
])
def test_a_wrong_marker_is_told_without_a_traceback(run_tests, words, complaint):
    """A word or value of the marker that there is not ends the test with one sentence."""
    result = run_tests(f"""
        import pytest

        @pytest.mark.armsim({words})
        def test_nothing(arm):
            pass
    """)
    result.assert_outcomes(errors=1)
    text = result.stdout.str()
    assert complaint in text
    assert 'Traceback' not in text
    assert 'site-packages' not in text.partition('short test summary')[0]


@statement('G2')
def test_the_nearest_marker_wins_word_by_word(run_tests):
    """Words of a test's marker win over those of its module, the others stay."""
    run_tests("""
        import pytest

        pytestmark = pytest.mark.armsim(robot='bot', seed=3)

        @pytest.mark.armsim(seed=4)
        def test_both(arm):
            assert arm.name == 'bot'
            assert arm.seed == 4
    """).assert_outcomes(passed=1)


@statement('G2')
def test_settings_are_overridden_by_dotted_words(run_tests):
    """A dotted word of the marker goes over the robot's files."""
    run_tests("""
        import pytest

        @pytest.mark.armsim(**{'simulation.gravity': [0, 0, 0]})
        def test_weightless(arm):
            arm.spawn('ball', xyz=(1.0, 0.0, 2.0), mass=0.1)
            arm.wait(0.5)
            assert abs(arm.entity('ball')[2, 3] - 2.0) < 1e-9
    """).assert_outcomes(passed=1)


@statement('G4')
def test_every_test_starts_from_the_same_state(run_tests):
    """What a test does to arm and world is not there in the next one, in either order."""
    text = """
        from armsim_ros.testing import assert_reached

        DIGESTS = []

        def test_moves_and_spawns(arm):
            DIGESTS.append(arm.digest())
            arm.spawn('box', xyz=(1.0, 0.0, 0.5), mass=0.2)
            arm.move_to('scan_food')

        def test_starts_anew(arm):
            DIGESTS.append(arm.digest())
            assert_reached(arm, 'home')
            assert len(set(DIGESTS)) == 1
    """
    run_tests(text).assert_outcomes(passed=2)


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


@statement('G7', 'F6')
def test_a_failed_test_leaves_a_recording(run_tests, pytester):
    """The report names seed, digest and time; the MCAP has states, reference, goal and words."""
    result = run_tests(BLOCKED)
    result.assert_outcomes(failed=1)
    text = result.stdout.str()
    for line in ('seed: 0', 'simulated time: 1.0', 'event: ', 'again: python -m pytest'):
        assert line in text
    assert re.search(r'digest: [0-9a-f]{64}', text)
    path = re.search(r'recording: (\S+\.mcap)', text)[1]
    assert path.startswith(str(pytester.path))
    topics = {}
    with open(path, 'rb') as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        assert reader.get_header().profile == 'ros2'
        for _, channel, _, message in reader.iter_decoded_messages():
            topics.setdefault(channel.topic, []).append(message)
    assert {'/sunday/joint_states', '/sunday/arm_joint_controller/controller_state',
            '/sunday/arm_joint_controller/joint_trajectory', '/sunday/robot_description', '/tf',
            '/rosout'} <= set(topics)
    state = topics['/sunday/arm_joint_controller/controller_state'][-1]
    assert state.reference.positions[0] == pytest.approx(0.3, abs=0.02)
    assert state.feedback.positions[0] == pytest.approx(0.0, abs=1e-3)
    assert topics['/sunday/arm_joint_controller/joint_trajectory'][0].joint_names[0] == 'joint_1'


@statement('G7')
def test_a_test_that_passed_leaves_nothing(run_tests, pytester):
    """Only failed tests write files, unless they are all to be kept."""
    run_tests(FIRST_TEST).assert_outcomes(passed=1)
    assert not (pytester.path / 'armsim-artifacts').exists()
    run_tests(FIRST_TEST, '--armsim-keep', '--armsim-artifacts=kept').assert_outcomes(passed=1)
    assert list((pytester.path / 'kept').glob('*.mcap'))


@statement('G7')
def test_the_facts_are_properties_of_the_junit_report(run_tests, pytester):
    """Seed, digest and recording stand in the XML report."""
    run_tests(BLOCKED, '--junitxml=report.xml')
    text = (pytester.path / 'report.xml').read_text()
    assert 'name="armsim digest"' in text
    assert 'name="armsim recording"' in text


@statement('G8')
def test_a_random_seed_is_printed_and_can_be_given(run_tests):
    """--armsim-seed=random chooses a seed, tells it in the header, and gives it to the arm."""
    result = run_tests("""
        def test_seed(arm):
            print('seed of the arm', arm.seed)
    """, '--armsim-seed=random', '-s')
    text = result.stdout.str()
    told = re.search(r'armsim: --armsim-seed=(\d+)', text)[1]
    assert f'seed of the arm {told}' in text


@statement('G8')
@pytest.mark.parametrize('option', ['--armsim-mode=real', '--armsim-seed=x'])
def test_a_wrong_option_is_a_usage_error(run_tests, option):
    """Options are checked before any test runs."""
    result = run_tests(FIRST_TEST, option)
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    assert option in result.stderr.str()


@statement('G8')
def test_a_simulated_time_limit_ends_a_test(run_tests):
    """A test that simulates longer than its limit fails with the arm's state."""
    result = run_tests("""
        import pytest

        @pytest.mark.armsim(time_limit=0.5)
        def test_long(arm):
            arm.wait(1000.0)
    """)
    result.assert_outcomes(failed=1)
    assert 'more than 0.5 s of simulated time; at 0.50' in result.stdout.str()


@statement('G8')
def test_a_wall_time_limit_ends_a_test_that_hangs(run_tests):
    """A test that stands still fails with the arm's state when its limit is over."""
    result = run_tests("""
        import threading

        import pytest

        @pytest.mark.armsim(time_limit=1)
        def test_hangs(arm):
            threading.Event().wait()
    """)
    result.assert_outcomes(failed=1)
    assert 'more than 1 s of wall time; at 0.000 s' in result.stdout.str()


def test_the_plugin_is_found_by_its_entry_point():
    """The installed package announces the plugin to pytest."""
    from importlib.metadata import entry_points

    found = {point.name: point.value for point in entry_points(group='pytest11')}
    assert found['armsim'] == 'armsim_ros.testing.plugin'
    assert 'armsim_ros.testing.plugin' in sys.modules


@statement('G3', 'G5')
def test_the_same_test_runs_on_the_real_programs(run_tests, pytester):
    """In mode process the fixture drives bringup on a leased domain, which ends with the test."""
    result = run_tests("""
        import os

        import pytest
        from armsim_ros import SimulationError
        from armsim_ros.testing import assert_reached, assert_rejected

        os.environ['ROS_DOMAIN_ID'] = '7'

        @pytest.mark.armsim(mode='process', faults={'joint_6': {'bias': 0.01}})
        def test_over_ros(arm, ros_domain):
            assert ros_domain != 7
            assert arm.name == 'sunday'
            arm.move_to('scan_food')
            assert_reached(arm, {'joint_5': 1.57})
            before = arm.time
            arm.wait(0.5)
            assert 0.5 <= arm.time - before < 5.0
            arm.follow([(1.0, arm.named_states['home'])])
            with pytest.raises(AssertionError, match="joint 'joint_6' is [+]0.01"):
                assert_reached(arm, 'home')
            assert_rejected(arm, [(1.0, [9.0] * 6)])
            arm.spawn('crate', (0.1, 0.1, 0.1), (0.8, 0.7, 0.05))
            assert arm.entity('crate')[:2, 3].tolist() == [0.8, 0.7]

        @pytest.mark.armsim(mode='process', faults={'joint_6': {'lag': 0.001}})
        def test_from_the_same_start(arm):
            assert max(map(abs, arm.positions.values())) < 0.001
            assert arm.time < 0.5
            with pytest.raises(SimulationError, match='crate'):
                arm.entity('crate')

        @pytest.mark.armsim(mode='process')
        def test_of_another_build(arm, request):
            assert max(map(abs, arm.positions.values())) < 0.001
            program = arm.robot.program
            request.addfinalizer(lambda: (program.process.kill(), program.wait(30.0)))

        @pytest.mark.armsim(mode='process')
        def test_after_programs_that_died(arm):
            assert max(map(abs, arm.positions.values())) < 0.001

        @pytest.fixture(autouse=True)
        def printed(arm, capsys):
            with capsys.disabled():
                print('PROGRAM', arm.robot.program.process.pid)
    """, '--armsim-keep')
    result.assert_outcomes(passed=4)
    first, second, third, fourth = re.findall(r'PROGRAM (\d+)', result.stdout.str())
    assert first == second
    assert len({second, third, fourth}) == 3
    recordings = list(pytester.path.glob('armsim-artifacts/*.mcap'))
    assert len(recordings) == 4


@statement('G5')
def test_programs_end_with_a_pytest_that_is_killed(pytester, monkeypatch, tmp_path):
    """No program outlives the tests, whatever became of them."""
    monkeypatch.setenv('PYTHONPATH', str(Path(__file__).parents[3]))
    pids = tmp_path / 'pids'
    pytester.makepyfile(f"""
        import threading

        def test_hangs(armsim_stack):
            with open({str(pids)!r}, 'w') as file:
                file.write(str(armsim_stack.program.process.pid))
            threading.Event().wait()
    """)
    user = Program([sys.executable, '-m', 'pytest', '-s'])
    with user:
        wait_until(lambda: pids.exists() and pids.read_text())
        bringup = Path('/proc', pids.read_text())
        children = [Path('/proc', pid) for pid in Path(
            bringup, 'task', bringup.name, 'children').read_text().split()]
        assert len(children) >= 2
        user.signal(signal.SIGKILL)
        wait_until(lambda: not any(path.exists() for path in (bringup, *children)))


def wait_until(condition, timeout=60.0):
    """Look until something is so."""
    deadline = time.monotonic() + timeout
    pause = threading.Event()
    while not condition():
        assert time.monotonic() < deadline
        pause.wait(0.05)
