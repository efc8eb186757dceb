# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What pytest tells of tests that fail, and what they leave."""

import re
from textwrap import dedent

from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
import pytest

statement = pytest.mark.statement

TESTS = """
    import sys
    import threading

    import pytest

    def test_light():  # the first of them: none has asked for an arm
        heavy = {'mujoco', 'rclpy', 'numpy', 'pydantic', 'coal', 'ompl'}
        assert not heavy & set(sys.modules)

    @pytest.mark.armsim(robt='sunday')
    def test_unknown_word(arm):
        pass

    @pytest.mark.armsim(mode='gazebo')
    def test_unknown_mode(arm):
        pass

    @pytest.mark.armsim(time_limit=0)
    def test_no_time(arm):
        pass

    @pytest.mark.armsim(robot='sundy')
    def test_unknown_robot(arm):
        pass

    @pytest.mark.armsim(faults={'joint_9': {'blocked': True}})
    def test_unknown_joint(arm):
        pass

    @pytest.mark.armsim(faults={'joint_1': {'blocked': True}})
    def test_turns(arm):
        from armsim_ros.testing import assert_reached

        arm.follow([(1.0, dict.fromkeys(arm.joints, 0.3))])
        assert_reached(arm, dict.fromkeys(arm.joints, 0.3))

    @pytest.mark.armsim(time_limit=5)
    def test_long(arm):
        arm.wait(1000.0)

    @pytest.mark.armsim(time_limit=0.25)
    def test_hangs(arm):
        threading.Event().wait()
"""


@pytest.fixture(scope='module')
def run(run_file):
    """Return what came of these tests."""
    return run_file(TESTS, '--junitxml=report.xml')


@statement('G1')
def test_the_plugin_imports_nothing_of_weight(run):
    """A test that asks for no arm imports neither MuJoCo nor rclpy nor numpy."""
    assert run.outcome('test_light') == 'passed'


@statement('G2')
@pytest.mark.parametrize(('test', 'complaint'), [
    ('test_unknown_word', "did you mean 'robot'?"),
    ('test_unknown_mode', 'allowed: inprocess, process'),
    ('test_no_time', 'must be above 0'),
    ('test_unknown_robot', "did you mean 'sunday'?"),
    ('test_unknown_joint', "joint 'joint_9'"),
])
def test_a_wrong_marker_is_told_without_a_traceback(run, test, complaint):
    """A word or value of the marker that there is not ends the test with one sentence."""
    assert run.outcome(test) == 'error'
    told = run.told(test)
    assert complaint in told
    assert 'Traceback' not in told
    assert 'site-packages' not in told


@statement('G7', 'F6')
def test_a_failed_test_leaves_a_recording(run):
    """The report names seed, digest and time; the MCAP has states, reference, goal and words."""
    assert run.outcome('test_turns') == 'failed'
    told = run.told('test_turns')
    for line in ('seed: 0', 'simulated time: 1.0', 'event: ', 'again: python -m pytest'):
        assert line in told
    assert re.search(r'digest: [0-9a-f]{64}', told)
    path = re.search(r'recording: (\S+\.mcap)', told)[1]
    assert path.startswith(str(run.folder))
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
def test_the_facts_are_properties_of_the_junit_report(run):
    """Seed, digest and recording stand in the XML report."""
    text = (run.folder / 'report.xml').read_text()
    assert 'name="armsim digest"' in text
    assert 'name="armsim recording"' in text


@statement('G8')
def test_a_simulated_time_limit_ends_a_test(run):
    """A test that simulates longer than its limit fails with the arm's state."""
    assert run.outcome('test_long') == 'failed'
    assert 'more than 5 s of simulated time; at 5.00' in run.told('test_long')


@statement('G8')
def test_a_wall_time_limit_ends_a_test_that_hangs(run):
    """A test that stands still fails with the arm's state when its limit is over."""
    assert run.outcome('test_hangs') == 'failed'
    assert 'more than 0.25 s of wall time; at 0.000 s' in run.told('test_hangs')


PLUGIN_THAT_TAKES_ITS_TIME = """
    import threading

    import pytest

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport():
        threading.Event().wait(0.3)
        return (yield)
"""


@statement('G8')
def test_the_wall_time_of_plugins_is_no_test_s(pytester, run_tests):
    """A report that takes longer than the limit ends neither the test nor pytest."""
    pytester.makeconftest(dedent(PLUGIN_THAT_TAKES_ITS_TIME))
    run = run_tests("""
        import pytest

        @pytest.mark.armsim(time_limit=0.25)
        def test_passes(arm):
            pass

        def test_that_follows():
            pass
    """)
    run.assert_outcomes(passed=2)


@statement('G8')
@pytest.mark.parametrize('fixture', [
    'threading.Event().wait(); yield', 'yield; threading.Event().wait()'], ids=['before', 'after'])
def test_a_fixture_that_hangs_is_ended(run_tests, fixture):
    """Whether before the test or after it."""
    run = run_tests(f"""
        import threading

        import pytest

        @pytest.fixture
        def cell(arm):
            {fixture}

        @pytest.mark.armsim(time_limit=0.25)
        def test_cell(cell):
            pass
    """)
    assert run.parseoutcomes()['errors'] == 1
    run.stdout.fnmatch_lines(['*more than 0.25 s of wall time; at 0.000 s*'])


@statement('G8')
def test_each_test_has_its_own_wall_time(run_tests):
    """The limit of a test does not depend on the test before it."""
    run = run_tests("""
        import threading

        import pytest

        @pytest.mark.armsim(time_limit=0.25)
        @pytest.mark.parametrize('again', [False, True])
        def test_hangs(arm, again):
            threading.Event().wait()
    """)
    run.assert_outcomes(failed=2)


FIXTURE_THAT_FAILS = """
    import pytest

    @pytest.fixture
    def cell():
        raise ValueError('no cell')
"""


@statement('G8')
def test_the_report_of_a_fixture_that_fails_is_the_user_s_alone(pytester, run_tests):
    """The hooks that limit the time of a test are not in it."""
    pytester.makeconftest(dedent(FIXTURE_THAT_FAILS))
    run = run_tests("""
        def test_cell(cell):
            pass
    """)
    run.stdout.fnmatch_lines(['*ValueError: no cell'])
    run.stdout.no_fnmatch_line('*armsim_ros/testing/*')
