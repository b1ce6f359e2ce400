# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
One self-contained HTML page that plays a recorded run in three dimensions, with plots beside it.

The page asks no network for anything: its modules (`page/`), the libraries (`vendor/`: three.js,
uPlot), and the run are inside, compressed; the browser unpacks them (DecompressionStream). It
works from a file, from a server, and as the `srcdoc` of a frame. Between two recorded instants the
browser interpolates; what is recorded is shown as recorded.
"""

from __future__ import annotations

import base64
import gzip
import json
from collections.abc import Mapping
from functools import cache
from html import escape
from importlib.resources import files
from string import Template
from typing import Any

from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.view.drawn_part import note_of
from rigid_body_sim.view.energy_history import EnergyHistory
from rigid_body_sim.view.page_record import Look, page_record
from rigid_body_sim.view.recorded_motion import RecordedMotion

LIBRARIES = {
    'three': 'three.module.min.js',
    'three/OrbitControls': 'OrbitControls.js',
    'uplot': 'uPlot.esm.js',
}
MODULES = (
    *('arrows', 'bodies', 'ground', 'impacts', 'keys', 'live', 'main', 'overlay', 'palette'),
    *('player', 'plots', 'run', 'shapes', 'stage', 'ties', 'trails'),
)


def playback_page(
    motion: RecordedMotion,
    scene: Scene | None,
    *,
    title: str,
    about: str = '',
    energy: EnergyHistory | None = None,
    bag: Bag | None = None,
) -> str:
    """
    Write the page of a run.

    scene  : shapes, forces and the expected outcome come from it; None: balls
    title  : headline;   about : behind it, small: integrator, tick length
    energy : for its plots; None: masses are unknown
    bag    : contact forces come from it, where it holds them
    """
    record, numbers, _ = page_record(motion, scene, energy=energy, bag=bag)
    caption = _caption(motion, scene)
    return _page(record, numbers, title, about, caption)


def live_page(
    motion: RecordedMotion,
    scene: Scene | None,
    *,
    title: str,
    about: str = '',
    live: Mapping[str, Any] | None = None,
) -> tuple[str, Look]:
    """
    Write the page of a run that goes on, and give what `page_record.more_of` needs for the rest.

    live : what it asks for more with: `run`, and `told`, the number of blocks that it holds
    """
    record, numbers, look = page_record(motion, scene, live=True)
    record['live'] = dict(live or {})
    return _page(record, numbers, title, about, _caption(motion, scene)), look


def _caption(motion: RecordedMotion, scene: Scene | None) -> str:
    """Say how far a run is drawn, and what should come out."""
    return ' '.join(filter(None, (note_of(motion), expected_outcome(scene))))


def expected_outcome(scene: Scene | None) -> str:
    """Comment at the head of a scene file: the physics and what should come out."""
    if scene is None:
        return ''
    lines = []
    for line in scene.source.decode('utf-8', 'replace').lstrip().splitlines():
        if not line.startswith('#'):
            break
        lines.append(line.lstrip('#').strip())
    return ' '.join(filter(None, lines))


def _page(record: dict[str, Any], numbers: bytes, title: str, about: str, caption: str) -> str:
    folder = files('rigid_body_sim.view')
    text = json.dumps(record, separators=(',', ':'), allow_nan=False)
    packs = [
        *_modules(),
        _pack('record', text.encode(), 'id'),
        _pack('numbers', numbers, 'id'),
    ]
    return Template((folder / 'page' / 'page.html').read_text('utf-8')).substitute(
        title=escape(title),
        about=escape(about),
        caption=escape(caption),
        plot_style=(folder / 'vendor' / 'uPlot.min.css').read_text('utf-8'),
        style=(folder / 'page' / 'page.css').read_text('utf-8'),
        packs='\n'.join(packs),
    )


@cache
def _modules() -> tuple[str, ...]:
    folder = files('rigid_body_sim.view')
    sources = {
        **{name: folder / 'vendor' / file for name, file in LIBRARIES.items()},
        **{f'view/{name}': folder / 'page' / f'{name}.js' for name in MODULES},
    }
    return tuple(_pack(name, file.read_bytes(), 'data-module') for name, file in sources.items())


def _pack(name: str, content: bytes, key: str) -> str:
    """Compress, the same bytes at any time, into an element that the page unpacks."""
    packed = base64.b64encode(gzip.compress(content, 9, mtime=0)).decode()
    return f'<script {key}="{name}" type="application/gzip">{packed}</script>'


def unpacked(page: str) -> tuple[dict[str, Any], bytes]:
    """Give record and numbers back out of the text of a page."""

    def content(name: str) -> bytes:
        packed = page.partition(f'<script id="{name}" type="application/gzip">')[2]
        return gzip.decompress(base64.b64decode(packed.partition('</script>')[0]))

    return json.loads(content('record')), content('numbers')
