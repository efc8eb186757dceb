# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Prints a shell's completion script, which calls this program for the possible words."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
import json
import os
from pathlib import Path
import subprocess
import sys

from armsim_ros.cli.arguments import argument_table, UsageError
from armsim_ros.cli.programs import PROGRAMS, ROBOT_PROGRAMS
from armsim_ros.resources import cell_names, PACKAGE, robot_names, share_folder

#: A robot that runs answers within this time [s]; the user waits for it.
_PATIENCE = 3.0
_FALSE_TRUE = ('true', 'false')
_CHOICES = {'mode': ('realtime', 'lockstep'), 'scene_from_world': ('live', 'fixed', 'false')}
_BASH = """\
# eval "$(armsim completion bash)", in ~/.bashrc
_armsim() {
    local line=${COMP_LINE:0:COMP_POINT} IFS=$'\\n'
    local word=${line##* }
    local before=${word%"${word##*[=:]}"}   # bash takes = and : for ends of words
    local -a words
    IFS=' ' read -r -a words <<< "$line"
    [[ $line == *' ' ]] && words+=('')
    COMPREPLY=($(armsim completion words "${words[@]:1}" 2> /dev/null))
    COMPREPLY=("${COMPREPLY[@]#"$before"}")
    [[ ${COMPREPLY[0]} == *= ]] && compopt -o nospace
}
complete -o default -F _armsim armsim
"""
_ZSH = """\
# eval "$(armsim completion zsh)", in ~/.zshrc after compinit
_armsim() {
    local -a found
    found=(${(f)"$(armsim completion words "${(@)words[2,CURRENT]}" 2> /dev/null)"})
    compadd -Q -a found || _files
}
compdef _armsim armsim
"""
_FISH = """\
# armsim completion fish | source, in ~/.config/fish/config.fish
function __armsim_words
    set -l words (commandline -opc) (commandline -ct)
    armsim completion words $words[2..] 2> /dev/null
end
complete -c armsim -a '(__armsim_words)'
"""
SCRIPTS = {'bash': _BASH, 'zsh': _ZSH, 'fish': _FISH}


def main(argv: Sequence[str] | None = None) -> int:
    """
    Print the script of a shell, or the words that can follow a command line.

    :param argv: the words after the program's name; those of this process where None.
    :returns: 0.
    :raises UsageError: there is no script for this shell.
    """
    words = list(sys.argv[1:] if argv is None else argv)
    if words[:1] == ['words']:
        sys.stdout.writelines(f'{word}\n' for word in candidates(words[1:]))
    elif len(words) == 1 and words[0] in SCRIPTS:
        print(SCRIPTS[words[0]], end='')
    elif {'-h', '--help'} & set(words):
        print(f"usage: armsim completion {'|'.join(SCRIPTS)}\n\nThe first line of the script "
              'shows how to load it.')
    else:
        raise UsageError(f"for which shell? allowed: {', '.join(SCRIPTS)}")
    return 0


def candidates(words: Sequence[str]) -> list[str]:
    """
    Return what the last word of a command line, without ``armsim``, can become.

    :param words: the last is what was typed of a word, '' before its first letter.
    """
    if len(words) < 2:
        return _beginning(PROGRAMS, words[-1] if words else '')
    program, typed = words[0], words[-1]
    if program in ROBOT_PROGRAMS:
        return _arguments(typed)
    if program == 'go':
        return _beginning([*_states(), '--group', '--speed', '--plan-only', '--list'], typed)
    if program == 'completion':
        return _beginning(SCRIPTS, typed)
    if program in ('copy', 'check_config') and len(words) == 2:
        return _beginning([*robot_names(), *cell_names()], typed)
    return []


def _arguments(typed: str) -> list[str]:
    table = {entry.name: entry for entry in argument_table()}
    name, sign, value = typed.partition(':=')
    if not sign:
        return _beginning([f'{each}:=' for each in table], typed)
    if name == 'robot':
        choices: Iterable[str] = (*robot_names(), *cell_names())
    elif name == 'world':
        choices = sorted(path.stem for path in (share_folder(PACKAGE) / 'worlds').iterdir()
                         if path.is_file() and not path.name.startswith('.'))
    elif name in table and isinstance(table[name].default, bool):
        choices = _FALSE_TRUE
    else:
        choices = _CHOICES.get(name, ())
    return [f'{name}:={each}' for each in _beginning(choices, value)] or _paths(name, value)


def _paths(name: str, value: str) -> list[str]:
    """Return folders and files that an argument can name."""
    folder, _, start = value.rpartition('/')
    place = Path(f'{folder}/' if '/' in value else '.').expanduser()
    if not place.is_dir():
        return []
    kept = value[:len(value) - len(start)]
    return [f"{name}:={kept}{path.name}{'/' if path.is_dir() else ''}"
            for path in sorted(place.iterdir())
            if path.name.startswith(start) and not path.name.startswith('.')]


def _states() -> list[str]:
    """Return the named states of the robot that runs, none where none runs."""
    try:
        done = subprocess.run(
            [sys.executable, '-m', PACKAGE, 'go', '--list', '--json', '--timeout', '1.5'],
            capture_output=True, text=True, timeout=_PATIENCE, check=False, env=os.environ)
    except subprocess.TimeoutExpired:
        return []
    if done.returncode:
        return []
    return sorted({state for states in json.loads(done.stdout).values() for state in states})


def _beginning(words: Iterable[str], typed: str) -> list[str]:
    return [word for word in words if word.startswith(typed)]
