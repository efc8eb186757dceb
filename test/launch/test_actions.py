# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Actions of launch files."""

import os

from armsim_ros.launch.engine import watchdog


def test_declare_launch_argument_sets_its_default_unless_given(entities):
    """P36 DeclareLaunchArgument: the default counts only where no value is given."""
    text = """
        DeclareLaunchArgument('who', default_value='anna'),
        node(LaunchConfiguration('who')),
    """
    assert list(entities(text).processes()) == ['anna']
    assert list(entities(text, 'who:=bert').processes()) == ['bert']


def test_a_missing_argument_is_named_with_its_choices(entities):
    """P41: an argument without a default is asked for, with its choices."""
    said = entities("DeclareLaunchArgument('who', choices=['anna', 'bert']), node('x'),")
    assert said.plan == ['needs argument: who choices=anna,bert']
    assert said.status == 2


def test_choices_may_be_a_text(entities):
    """A text as choices allows its parts, as Python's ``in`` does in launch."""
    said = entities("""
        DeclareLaunchArgument('arm', choices='ur5e', default_value='ur5'), node('x'),
    """)
    assert list(said.processes()) == ['x']
    said = entities("DeclareLaunchArgument('arm', choices='ur5e'),", 'arm:=ur10')
    assert "argument 'arm' is 'ur10'; allowed: ur5e" in said.errors


def test_choices_are_checked(entities):
    """P37: a value that is none of the choices is refused, with the line of the file."""
    said = entities("DeclareLaunchArgument('who', choices=['anna', 'bert']),", 'who:=otto')
    assert said.status == 2
    assert 'it.launch.py:' in said.errors
    assert "argument 'who' is 'otto'; allowed: anna, bert" in said.errors


def test_a_group_scopes_configurations(entities):
    """P37 GroupAction, SetLaunchConfiguration: what a group sets ends with it."""
    said = entities("""
        SetLaunchConfiguration('a', 'outside'),
        GroupAction([SetLaunchConfiguration('a', 'inside'), node(LaunchConfiguration('a'))]),
        node(LaunchConfiguration('a')),
    """)
    assert list(said.processes()) == ['inside', 'outside']


def test_an_unscoped_group_does_not(entities):
    """P37 GroupAction: scoped=False leaves what it sets."""
    said = entities("""
        GroupAction([SetLaunchConfiguration('a', 'inside')], scoped=False),
        node(LaunchConfiguration('a')),
    """)
    assert list(said.processes()) == ['inside']


def test_a_group_without_forwarding_begins_anew(entities):
    """launch/actions/group_action.py, get_sub_entities: configurations and environment."""
    said = entities("""
        SetLaunchConfiguration('outside', 'x'),
        SetEnvironmentVariable('NOT_SET_BEFORE', 'x'),
        GroupAction([
            node(LaunchConfiguration('kept')),
            node(LaunchConfiguration('outside', default='forgotten')),
            node(EnvironmentVariable('NOT_SET_BEFORE', default_value='unset')),
        ], forwarding=False, launch_configurations={'kept': LaunchConfiguration('outside')}),
    """)
    assert list(said.processes()) == ['x', 'forgotten', 'unset']


def test_an_include_is_not_scoped(entities, write):
    """P37 IncludeLaunchDescription, ThisLaunchFileDir: arguments of an include stay."""
    write("""
        from launch import LaunchDescription
        from launch.actions import DeclareLaunchArgument
        from launch.substitutions import LaunchConfiguration
        from launch_ros.actions import Node

        def generate_launch_description():
            return LaunchDescription([
                DeclareLaunchArgument('who', default_value='nobody'),
                Node(package='mine', executable='two', name=LaunchConfiguration('who'))])
    """, 'inner.launch.py')
    said = entities("""
        IncludeLaunchDescription(
            PythonLaunchDescriptionSource([ThisLaunchFileDir(), '/inner.launch.py']),
            launch_arguments={'who': 'given'}.items()),
        node(['after_', LaunchConfiguration('who')]),
    """)
    assert list(said.processes()) == ['given', 'after_given']


def test_arguments_of_an_include_see_the_earlier_ones(entities, write):
    """launch/actions/include_launch_description.py, execute: each is set before the next."""
    write("""
        from launch import LaunchDescription
        from launch.substitutions import LaunchConfiguration
        from launch_ros.actions import Node

        def generate_launch_description():
            return LaunchDescription([Node(
                package='mine', executable='two', name=LaunchConfiguration('prefix'))])
    """, 'inner.launch.py')
    said = entities("""
        SetLaunchConfiguration('robot', 'old'),
        IncludeLaunchDescription(
            [ThisLaunchFileDir(), '/inner.launch.py'],
            launch_arguments={'robot': 'new', 'prefix': [LaunchConfiguration('robot'), '_']}),
    """)
    assert list(said.processes()) == ['new_']


def test_an_argument_that_a_condition_decides_about_is_not_demanded(entities):
    """launch/launch_description.py, process_entities: _conditionally_included."""
    said = entities("""
        GroupAction([DeclareLaunchArgument('robot_ip'), node('real')],
                    condition=IfCondition('false')),
        node('simulated'),
    """)
    assert list(said.processes()) == ['simulated']


def test_an_include_names_the_arguments_that_it_needs(entities, write):
    """P41: what an included file needs is asked for, all of it."""
    write("""
        from launch import LaunchDescription
        from launch.actions import DeclareLaunchArgument

        def generate_launch_description():
            return LaunchDescription([DeclareLaunchArgument('a'), DeclareLaunchArgument('b')])
    """, 'inner.launch.py')
    said = entities("""
        IncludeLaunchDescription([ThisLaunchFileDir(), '/inner.launch.py']), node('goes_on'),
    """)
    assert said.plan[:2] == ['needs argument: a choices=', 'needs argument: b choices=']


def test_an_opaque_function_returns_entities(entities):
    """P36 OpaqueFunction: gets the context, returns what is visited next."""
    said = entities("""
        DeclareLaunchArgument('n', default_value='2'),
        OpaqueFunction(function=lambda context, prefix: [
            node(f'{prefix}{i}') for i in range(int(
                LaunchConfiguration('n').perform(context)))], args=['x']),
    """)
    assert list(said.processes()) == ['x0', 'x1']


def test_exit_handlers_chain(entities):
    """P36 RegisterEventHandler, OnProcessExit: what follows a process starts after it."""
    said = entities("""
        first := node('first'),
        RegisterEventHandler(OnProcessExit(target_action=first, on_exit=[
            second := node('second'),
            RegisterEventHandler(OnProcessExit(target_action=second, on_exit=[node('third')])),
        ])),
        node('beside'),
    """)
    assert list(said.processes()) == ['first', 'beside', 'second', 'third']


def test_start_handlers_and_timers(entities):
    """P36 OnProcessStart, TimerAction: after the start; timers in the order of their times."""
    said = entities("""
        TimerAction(period=5.0, actions=[node('late')]),
        TimerAction(period='1.5', actions=[node('soon')]),
        first := node('first'),
        RegisterEventHandler(OnProcessStart(target_action=first, on_start=[node('next')])),
    """)
    assert list(said.processes()) == ['first', 'next', 'soon', 'late']


def test_a_timer_sees_the_configurations_of_its_group(entities):
    """P36 TimerAction, P37 GroupAction: what the group had set holds for its later actions."""
    said = entities("""
        GroupAction([SetLaunchConfiguration('a', 'inside'),
                     TimerAction(period=1.0, actions=[node(LaunchConfiguration('a'))])]),
    """)
    assert list(said.processes()) == ['inside']


def test_events_and_shutdown_are_accepted(entities):
    """P36 EmitEvent, Shutdown, OnShutdown, LogInfo: a dry run goes on after them."""
    said = entities("""
        RegisterEventHandler(OnShutdown(on_shutdown=[LogInfo(msg='the end')])),
        node('one', on_exit=[Shutdown(reason='done')]),
        EmitEvent(event=ShutdownEvent(reason='now')),
        LogInfo(msg=['hello ', 'world']),
        node('two'),
    """)
    assert list(said.processes()) == ['one', 'two']
    assert '[INFO] [launch.user]: hello world' in said.errors


def test_environment_variables(entities):
    """P36 SetEnvironmentVariable: later texts see it."""
    said = entities("""
        SetEnvironmentVariable('ROOM', 'kitchen'),
        AppendEnvironmentVariable('ROOM', 'sink', separator='_'),
        node(EnvironmentVariable('ROOM')),
    """)
    assert list(said.processes()) == ['kitchen_sink']


def test_execute_process(entities):
    """P36 ExecuteProcess, FindExecutable: a program by its path, shown without it."""
    said = entities("ExecuteProcess(cmd=[FindExecutable(name='sh'), '-c', 'true'], name='it'),")
    assert said.plan == ['process: -/sh name=it ns=/ parameters=']


def test_conditions(entities):
    """P36 IfCondition, UnlessCondition: true, false, 1, 0; other words are refused."""
    said = entities("""
        *(node(f'if_{word}', condition=IfCondition(word)) for word in ('true', '0', 'False', '1')),
        *(node(f'not_{word}', condition=UnlessCondition(word)) for word in ('true', '0')),
        node('x', condition=IfCondition('perhaps')),
    """)
    assert list(said.processes()) == ['if_true', 'if_1', 'not_0']
    assert "a condition is 'perhaps'; allowed: true, false, 1, 0" in said.errors
    assert said.status == 2


def test_a_condition_is_asked_by_a_launch_file(entities):
    """Launch files ask a condition by the private name that it has in the original."""
    said = entities("""
        OpaqueFunction(function=lambda context: [
            node(str(IfCondition(word)._predicate_func(context))) for word in ('true', '0')]),
    """)
    assert list(said.processes()) == ['True', 'False']


def test_a_circle_of_exit_handlers_is_stopped(entities):
    """A process that its own exit starts again and again ends the dry run with a message."""
    said = entities("""
        OpaqueFunction(function=lambda context: [again := node('again'), RegisterEventHandler(
            OnProcessExit(target_action=again, on_exit=[again]))]),
    """)
    assert said.status == 2
    assert 'an exit handler seems to start its own process again' in said.errors


def test_the_end_of_a_process_and_of_a_timer_are_complete_executions(entities):
    """launch/action.py, visit: ExecutionComplete comes with the end of what the action started."""
    said = entities("""
        RegisterEventHandler(OnExecutionComplete(
            target_action=(first := node('first')), on_completion=[node('after_first')])),
        RegisterEventHandler(OnExecutionComplete(
            target_action=(absent := Node(package='nowhere', executable='x')),
            on_completion=[node('after_absent')])),
        RegisterEventHandler(OnExecutionComplete(
            target_action=(timer := TimerAction(period=2.0, actions=[node('timed')])),
            on_completion=[node('after_timer')])),
        timer, TimerAction(period=1.0, actions=[node('soon')]), first, absent,
    """)
    assert list(said.processes()) == [
        'first', 'after_first', 'after_absent', 'soon', 'timed', 'after_timer']


def test_an_action_that_starts_nothing_is_complete_after_its_visit(entities):
    """launch/action.py, visit: the event comes at once; not if the condition does not hold."""
    said = entities("""
        RegisterEventHandler(OnExecutionComplete(
            target_action=(done := LogInfo(msg='x')), on_completion=[node('after')])),
        RegisterEventHandler(OnExecutionComplete(
            target_action=(skipped := LogInfo(msg='y', condition=IfCondition('0'))),
            on_completion=[node('never')])),
        done, skipped,
    """)
    assert list(said.processes()) == ['after']


def test_a_handler_that_is_registered_later_misses_the_completion(entities):
    """launch/action.py, visit: only a handler that is there at the visit counts."""
    said = entities("""
        first := node('first'),
        RegisterEventHandler(OnExecutionComplete(
            target_action=first, on_completion=[node('after_first')])),
    """)
    assert list(said.processes()) == ['first']


def test_a_coroutine_is_complete_at_its_end(entities):
    """launch/actions/opaque_coroutine.py, get_asyncio_future: its future is the coroutine's."""
    said = entities("""
        RegisterEventHandler(OnExecutionComplete(
            target_action=(waits := OpaqueCoroutine(coroutine=asyncio.sleep, args=[0.01],
                                                    ignore_context=True)),
            on_completion=[node('after')])),
        waits,
    """, before='import asyncio')
    assert list(said.processes()) == ['after']


def test_completions_that_cause_each_other_for_ever_are_stopped(entities, monkeypatch):
    """A handler of all actions is fired by its own actions, too."""
    monkeypatch.setattr(watchdog.__wrapped__, '__defaults__', (0.2,))
    said = entities("""
        RegisterEventHandler(OnExecutionComplete(on_completion=[LogInfo(msg='again')])),
    """)
    assert said.status == 2
    assert 'the launch file does not come to an end' in said.errors


def test_the_environment_is_that_of_the_launch_program(entities, monkeypatch):
    """launch/launch_context.py, environment: os.environ, for the file's own code, too."""
    monkeypatch.delenv('ROOM', raising=False)
    said = entities("""
        node(EnvironmentVariable('ROOM')),
        GroupAction([
            SetEnvironmentVariable('ROOM', 'kitchen'),
            OpaqueFunction(function=lambda context: [node(os.environ['ROOM'])])]),
        OpaqueFunction(function=lambda context: [node(f"{os.environ['ROOM']}_again")]),
        ResetEnvironment(),
        node(EnvironmentVariable('ROOM', default_value='none')),
    """, before="import os\nos.environ['ROOM'] = 'hall'")
    assert list(said.processes()) == ['hall', 'kitchen', 'hall_again', 'none']
    assert 'ROOM' not in os.environ
