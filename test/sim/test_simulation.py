# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The plant as a whole: start, reset, determinism, faults."""

from dataclasses import replace

import numpy as np
import pytest

from armsim_ros.config.controllers.pid_controller import PidGains
from armsim_ros.config.simulation import PlacementSettings, SimulationSettings
from armsim_ros.config.world import WorldSettings
from armsim_ros.errors import SimulationError
from armsim_ros.model.robot_model import Inertial, JointLimits, JointType
from armsim_ros.model.semantic_model import SemanticModel
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.sim.simulation import Simulation


def run(simulation, steps):
    """Step on with the present commands."""
    for _ in range(steps):
        simulation.step()


def move(simulation, steps, speed=0.5):
    """Command a ramp."""
    start = simulation.state.position.copy()
    for k in range(steps):
        simulation.command.position[:] = start + speed * (k + 1) * 1e-3
        simulation.write()
        simulation.step()


def test_two_runs_are_equal_to_the_bit(arm, claim):
    """The same commands give the same digest, another command another one."""
    digests = []
    for speed in (0.5, 0.5, 0.5001):
        simulation = Simulation(arm)
        claim(simulation, 'position')
        move(simulation, 300, speed)
        digests.append(simulation.digest())
    assert digests[0] == digests[1] != digests[2]


@pytest.mark.parametrize('at_once', [2, 4])
def test_steps_whose_inputs_are_not_known_yet_are_made_singly(arm, claim, at_once):
    """Several steps in one call are the same as one by one, right after a command too."""
    digests = []
    for sizes in ([at_once], [1] * at_once):
        simulation = Simulation(arm)
        claim(simulation, 'position')
        for number in range(1, 50):
            simulation.command.position[:] = 1e-3 * number
            simulation.write(at_once)
            for size in sizes:
                simulation.step(size)
        digests.append(simulation.digest())
    assert digests[0] == digests[1]


def test_reset_repeats_the_start(simulation):
    """After a reset the robot is where it started and at rest; time has gone on."""
    move(simulation, 200)
    simulation.reset()
    np.testing.assert_array_equal(simulation.state.position, 0.0)
    np.testing.assert_array_equal(simulation.state.velocity, 0.0)
    assert simulation.time_ns == 200_000_000
    for _ in range(100):
        simulation.step()
    np.testing.assert_allclose(simulation.state.position, 0.0, atol=1e-9)


def put_elsewhere(simulation):
    """Put two joints elsewhere."""
    simulation.set_positions({'shoulder': 0.3, 'wrist': -0.2})


@pytest.mark.parametrize('again', [Simulation.reset, Simulation.recover, put_elsewhere])
def test_no_drive_acts_yet_where_the_robot_is_put(simulation, again):
    """What drives did elsewhere is neither an effort nor an acceleration of the joints."""
    move(simulation, 400)
    assert np.abs(simulation.state.effort).max() > 0.1
    again(simulation)
    np.testing.assert_array_equal(simulation.state.effort, 0.0)
    np.testing.assert_array_equal(simulation.state.acceleration, 0.0)
    position = simulation.state.position.copy()
    for _ in range(200):
        simulation.write()
        simulation.step()
        assert np.abs(simulation.state.effort).max() < 10.0
    np.testing.assert_allclose(simulation.state.position, position, atol=1e-3)


def test_digests_after_two_resets_are_equal(arm, claim):
    """Whatever happened before them."""
    digests = []
    for steps in (1, 300):
        simulation = Simulation(arm)
        claim(simulation, 'position')
        move(simulation, steps)
        simulation.reset()
        simulation.clock.reset()
        digests.append(simulation.digest())
    assert digests[0] == digests[1]


def test_starts_in_a_named_state_with_single_joints_over_it(arm):
    """O10: initial positions win over the named state; both are checked."""
    states = {'manipulator': {'ready': {'shoulder': 0.4, 'elbow': 0.2}}}
    named = replace(arm, semantic=SemanticModel(named_states=states))
    settings = SimulationSettings(initial_state='ready', initial_positions={'elbow': -0.1})
    np.testing.assert_allclose(Simulation(named, settings).state.position, (0.4, -0.1, 0.0))


@pytest.mark.parametrize(
    ('changes', 'words'),
    [
        ({'initial_positions': {'elbo': 0.1}}, "'elbow'"),
        ({'initial_positions': {'elbow': 9.0}}, '-2.8 to 2.8'),
        ({'initial_state': 'redy'}, "'redy'"),
    ],
)
def test_refuses_a_start_that_does_not_fit(arm, changes, words):
    """A wrong initial joint, position or state is named, with what is allowed."""
    with pytest.raises(SimulationError, match=words):
        Simulation(arm, SimulationSettings(**changes))


def test_stands_where_it_is_placed(arm):
    """O10: -x -y -z and the orientation place the root link."""
    placement = PlacementSettings(xyz=(1.0, 2.0, 3.0), rpy=(0.0, 0.0, np.pi / 2))
    simulation = Simulation(arm, SimulationSettings(placement=placement))
    np.testing.assert_allclose(simulation.link_pose('base')[:3, 3], (1, 2, 3))
    np.testing.assert_allclose(simulation.link_pose('hand')[:3, 3], (1, 2, 3.5))
    np.testing.assert_allclose(simulation.link_pose('base')[:3, 0], (0, 1, 0), atol=1e-12)


def test_a_continuous_joint_is_not_wrapped(make_arm, claim):
    """O5: a continuous joint's position counts on past a turn."""
    simulation = Simulation(
        make_arm(type=JointType.CONTINUOUS, limits=JointLimits(velocity=10.0, effort=30.0))
    )
    claim(simulation, 'position')
    for k in range(2000):
        simulation.command.position[:] = (0.0, 0.0, 4e-3 * (k + 1))
        simulation.write()
        simulation.step()
    assert simulation.state.position[2] == pytest.approx(8.0, abs=1e-3)


def test_a_joint_that_cannot_move_stays(make_arm, claim):
    """Equal limits, to which urdfdom's parseJointLimits sets those that are missing, are held."""
    simulation = Simulation(make_arm(limits=JointLimits(0.1, 0.1, velocity=3.0, effort=30.0)))
    assert simulation.state.position[2] == pytest.approx(0.1)
    claim(simulation, 'effort')
    simulation.command.effort[2] = 5.0
    simulation.write()
    run(simulation, 500)
    assert simulation.state.position[2] == pytest.approx(0.1, abs=1e-3)


def test_end_stops_hold_against_efforts(make_arm, claim):
    """A joint that is pressed against its stop stays there, and does not overshoot far."""
    simulation = Simulation(make_arm(limits=JointLimits(-0.5, 0.5, velocity=3.0, effort=30.0)))
    claim(simulation, 'effort')
    simulation.command.effort[2] = 1.0
    simulation.write()
    farthest = 0.0
    for _ in range(1000):
        run(simulation, 1)
        farthest = max(farthest, simulation.state.position[2])
    assert farthest < 0.55
    assert simulation.state.position[2] == pytest.approx(0.5, abs=1e-4)


@pytest.mark.parametrize('inertia', [
    [[9e-6, -1e-6, 0.0], [-1e-6, 1e-6, 0.0], [0.0, 0.0, 1e-5]],
    np.diag((0.005208, 0.005208, 0.010417))])
def test_a_flat_link_is_simulated(arm, inertia):
    """Principal inertias of which two add up to the third, but for rounding, are not refused."""
    inertial = Inertial(0.3, pose_matrix((0.0, 0.0, 0.1)), np.array(inertia))
    hand = replace(arm.links['hand'], inertial=inertial)
    simulation = Simulation(replace(arm, links={**arm.links, 'hand': hand}))
    assert not simulation.warnings


def test_a_planar_joint_is_refused_by_name(make_arm):
    """A joint type without physics is named together with those that have it."""
    with pytest.raises(SimulationError, match=r"'wrist'.*planar.*revolute"):
        Simulation(make_arm(type=JointType.PLANAR))


def test_an_unstable_joint_is_named_and_the_plant_recovers(arm, claim):
    """Gains far beyond the timestep end in an error with the joint's name; recovery is at rest."""
    wild = PidGains(p=1e8)
    limits = replace(arm.joints['wrist'].limits, effort=np.inf, velocity=np.inf)
    loose = replace(
        arm, joints={**arm.joints, 'wrist': replace(arm.joints['wrist'], limits=limits)}
    )
    simulation = Simulation(loose, gains={'wrist': wild})
    claim(simulation, 'position')
    assert 'wrist' in simulation.warnings[0]
    simulation.command.position[:] = 0.01
    simulation.write()
    with pytest.raises(SimulationError, match="joint 'wrist'"):
        run(simulation, 5000)
    assert np.isfinite(simulation.state.position).all()
    simulation.recover()
    np.testing.assert_array_equal(simulation.state.velocity, 0.0)
    assert np.abs(simulation.state.position).max() < 3.0


def test_a_moving_link_without_mass_gets_some_and_says_so(arm, claim):
    """It is made light in its origin, pulls to no side, and a warning names it."""
    links = {**arm.links, 'hand': replace(arm.links['hand'], inertial=None)}
    simulation = Simulation(replace(arm, links=links), world=WorldSettings(floor=False))
    assert any("'hand'" in warning for warning in simulation.warnings)
    claim(simulation, 'effort')
    simulation.command.effort[:] = 0.0
    for _ in range(100):
        simulation.write()
        simulation.step()
    # Upright, on its line of balance.
    np.testing.assert_allclose(simulation.state.position, 0.0, atol=1e-9)


def test_joints_can_be_put_elsewhere(simulation):
    """Joints put elsewhere are there at once, at rest, and stay."""
    simulation.set_positions({'elbow': 0.7})
    np.testing.assert_allclose(simulation.state.position, (0.0, 0.7, 0.0))
    for _ in range(100):
        simulation.write()
        simulation.step()
    np.testing.assert_allclose(simulation.state.position, (0.0, 0.7, 0.0), atol=1e-6)
    with pytest.raises(SimulationError, match=r"no joint 'elbw'.*'elbow'"):
        simulation.set_positions({'elbw': 0.0})


def test_an_unstable_plant_leaves_no_file_behind(arm, tmp_path, monkeypatch, capfd):
    """MuJoCo's own warning file and print do not appear: the error says it."""
    monkeypatch.chdir(tmp_path)
    simulation = Simulation(arm)
    simulation.apply_wrench('hand', force=(1e12, 0.0, 0.0))
    with pytest.raises(SimulationError, match='unstable'):
        run(simulation, 10)
    assert list(tmp_path.iterdir()) == []
    assert capfd.readouterr().out == ''
