# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The graph that view_frames writes (tf2_tools/tf2_tools/view_frames.py: generate_dot)."""

import pytest

from armsim_ros.nodes.upstream.view_frames import format_graph, main


def frame(parent: str) -> dict[str, str]:
    """Return what the buffer has of a frame."""
    return {'parent': parent, 'broadcaster': 'default_authority', 'rate': '20.500',
            'most_recent_transform': '12.250000', 'oldest_transform': '2.250000',
            'buffer_length': '10.000'}


def test_the_graph_is_upstreams() -> None:
    """An edge per frame, and a legend above the root."""
    assert format_graph({'tool': frame('base')}, 12.5) == """digraph G {
"base" -> "tool"[label=" Broadcaster: default_authority\\nAverage rate: 20.5\\n\
Buffer length: 10.0\\nMost recent transform: 12.25\\nOldest transform: 2.25\\n"];
edge [style=invis];
 subgraph cluster_legend { style=bold; color=black; label ="view_frames Result";
"Recorded at time: 12.5"[ shape=plaintext ] ;
}->"base";
}"""


def test_a_loop_has_no_root() -> None:
    """Its legend stands alone, where upstream fails."""
    lines = format_graph({'a': frame('b'), 'b': frame('a')}, 0.0).splitlines()
    assert lines[-2:] == ['}', '}']


def test_without_frames_the_graph_says_so() -> None:
    """A single node."""
    assert format_graph({}, 0.0) == 'digraph G { "No tf data received" }'


def test_unknown_options_are_refused() -> None:
    """As by argparse upstream."""
    with pytest.raises(SystemExit) as ended:
        main(['--nope'])
    assert ended.value.code == 2
