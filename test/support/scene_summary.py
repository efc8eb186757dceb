# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The content of a scene in a form that can be compared."""


def summary(content):
    """Return what a content holds in a form that can be compared."""
    def body(item):
        return (
            item.id, item.type, item.pose.round(9).tolist(),
            [(repr(s.geometry), s.pose.round(9).tolist()) for s in item.shapes],
            {name: pose.round(9).tolist() for name, pose in item.subframes.items()},
        )

    names = sorted(content.acm.names)
    return {
        'q': content.q.round(9).tolist(),
        'objects': {id_: body(item) for id_, item in content.objects.items()},
        'attached': {
            id_: (item.link_name, item.touch_links, item.weight, body(item.object))
            for id_, item in content.attached.items()
        },
        'acm': [(a, b) for a in names for b in names if content.acm.allowed(a, b) and a != b],
        'padding': dict(content.link_padding),
        'scale': dict(content.link_scale),
        'frames': {
            name: (frame.parent, frame.pose.tolist()) for name, frame in content.frames.items()
        },
        'fixed_frames': {name: pose.tolist() for name, pose in content.fixed_frames.items()},
        'colors': dict(content.colors),
    }
