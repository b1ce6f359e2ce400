# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Makes the gallery of the documentation from the shipped scenes: pictures, one film, and the page.

    python tools/gallery.py [NAME ...]     all, or only these pictures again

Each scene is run, its page drawn by a headless Chromium at one instant, light or dark, and kept as
a PNG of at most 256 colours in `docs/gallery`; `flipping_box.gif` is the film for the README.
`docs/gallery.md` names them with the words of their scenes.
"""

from __future__ import annotations

import sys
import tempfile
from io import BytesIO
from pathlib import Path
from typing import NamedTuple

from PIL import Image

from rigid_body_sim.__main__ import main
from rigid_body_sim.scene import load_scene
from rigid_body_sim.view import chromium
from rigid_body_sim.view.film import READY
from rigid_body_sim.view.playback_page import expected_outcome

ROOT = Path(__file__).resolve().parents[1]
TARGET = ROOT / 'docs' / 'gallery'
SIZE = (720, 460)  # [pixel]
COLORS = 256
FILM = 'flipping_box'
FILM_WORDS = ('--size', '640x400', '--fps', '20', '--speed', '1.5')
WHOLE_PAGE = ('satellite', 'stack')  # drawn with controls and plots too, light and dark
PAGE_SIZE = (1280, 900)  # [pixel]


class Shot(NamedTuple):
    """One picture: scene, instant [s], and whether on a dark ground."""

    scene: str
    time: float
    dark: bool = False


SHOTS = (
    Shot('tumbling_box', 2.2),
    Shot('heavy_top', 1.0),
    Shot('spinning_coin', 0.4),
    Shot('satellite', 5.0, dark=True),
    Shot('two_bodies', 0.12),
    Shot('stack', 2.0, dark=True),
    Shot('domino_row', 1.2),
    Shot('pile_of_1000', 4.0),
    Shot('pyramid', 1.0),
    Shot('newtons_cradle', 0.3, dark=True),
    Shot('striking_pendulum', 0.4),
    Shot('deck_landing', 3.0),
    Shot('sea_bed', 1.2),
    Shot('bouncing_ball', 0.7),
    Shot('spring_ball', 0.3, dark=True),
    Shot('elastic_push', 0.3),
    Shot('ten_bodies', 2.0),
    Shot('incline', 1.5),
    Shot('hovering_drone', 2.0, dark=True),
    Shot('quadrotor', 0.3),
)


def _run(*words: object) -> None:
    code = main([str(word) for word in words])
    if code:
        raise SystemExit(code)


def _recorded(folder: Path, shot: Shot) -> Path:
    """Run the scene; returns its page."""
    bag, page = folder / shot.scene, folder / f'{shot.scene}.html'
    words: list[object] = ['simulate', shot.scene, '-o', bag]
    contact = load_scene(ROOT / 'config' / 'scenes' / f'{shot.scene}.yaml').contact
    if contact.get('mode', 'none') != 'none':
        words.append('--contacts')
    _run(*words)
    _run('view', bag, '-o', page)
    return page


def _keep(picture: bytes, name: str) -> None:
    """Keep a PNG in few colours: four times smaller, and nobody sees it."""
    with Image.open(BytesIO(picture)) as image:
        few = image.convert('RGB').quantize(COLORS, dither=Image.Dither.NONE)
    few.save(TARGET / f'{name}.png', optimize=True)


def _draw(tab: chromium.Page, page: Path, shot: Shot) -> None:
    theme = 'dark' if shot.dark else 'light'
    for film, (width, height) in ((True, SIZE), (False, PAGE_SIZE)):
        if not film and shot.scene not in WHOLE_PAGE:
            continue
        wishes = f'theme={theme}&t={shot.time}{"&film" if film else ""}'
        tab.open('about:blank')
        tab.open(f'{page.as_uri()}#{wishes}', width=width, height=height)
        tab.wait_for(READY)
        tab.evaluate(f'view.seek({shot.time})')
        tab.settle()
        _keep(tab.picture(), shot.scene if film else f'page_{shot.scene}')


def _write_page() -> None:
    """Write docs/gallery.md: each picture with the words of its scene."""
    parts = [
        '# Gallery\n',
        'Made by `python tools/gallery.py` from the shipped scenes. Run one yourself:\n',
        '```sh\nrigid_body_sim simulate tumbling_box -o run\nrigid_body_sim view run -o run.html\n'
        'rigid_body_sim view run -o run.gif\n```\n',
        'What the page shows and which keys it knows: [view](view.md).\n',
        f'![A box that turns over, and over again](gallery/{FILM}.gif)\n',
    ]
    for shot in SHOTS:
        scene = load_scene(ROOT / 'config' / 'scenes' / f'{shot.scene}.yaml')
        words, _, expected = expected_outcome(scene).partition('Expected')
        parts.append(f'## {shot.scene}\n')
        parts.append(f'{words.strip()}\n')
        parts.append(f'![{shot.scene} at {shot.time:g} s](gallery/{shot.scene}.png)\n')
        parts.append(f'*Expected{expected.strip()}*\n')
    (ROOT / 'docs' / 'gallery.md').write_text('\n'.join(parts), encoding='utf-8')


def make(names: list[str]) -> None:
    """Make the pictures of these scenes, or all."""
    TARGET.mkdir(exist_ok=True)
    wanted = [shot for shot in SHOTS if not names or shot.scene in names]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        with chromium.page(folder / 'profile') as tab:
            for shot in wanted:
                _draw(tab, _recorded(folder, shot), shot)
        if not names or FILM in names:
            bag = folder / 'film'
            _run('simulate', 'tumbling_box', '-o', bag, '--duration', 7.732)  # two turns over
            _run('view', bag, '-o', TARGET / f'{FILM}.gif', *FILM_WORDS)
    _write_page()


if __name__ == '__main__':
    make(sys.argv[1:])
