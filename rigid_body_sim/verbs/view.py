# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Draws a recorded run: what should come out, paths, attitude, rates, commands, energy and the
conservation laws as one PNG; the motion itself as a page that plays in a browser (HTML), or as a
film (GIF, MP4), whose frames a headless Chromium draws.
"""

from __future__ import annotations

import argparse
import re
import tempfile
import warnings
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

from rigid_body_sim.analysis.scene_begin import scene_began
from rigid_body_sim.command_line import whole
from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.errors import choose_from
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.recording.every_body import with_every_body
from rigid_body_sim.recording.mcap_scan import MOST_TIME
from rigid_body_sim.recording.new_output import FULL, check_folder, not_written, replacing
from rigid_body_sim.recording.record_values import RecordValues
from rigid_body_sim.runs.reading_guard import reads_recording
from rigid_body_sim.runs.warning_lines import warning_printer
from rigid_body_sim.scene import load_scene
from rigid_body_sim.stop_signals import STOP
from rigid_body_sim.view.drawn_part import drawn_part
from rigid_body_sim.view.energy_history import energy_history
from rigid_body_sim.view.film import SUFFIXES, FilmSettings, film, need_tools
from rigid_body_sim.view.picture import picture
from rigid_body_sim.view.playback_page import expected_outcome, playback_page
from rigid_body_sim.view.recorded_motion import RecordedMotion, read_motion

SUMMARY = 'draw a recorded run as a PNG, or play it in three dimensions: HTML page, GIF, MP4'

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SCENE = 'scene.yaml'
DOTS_PER_INCH = 130
LACKS = re.compile(r'Glyph (\d+) .* missing from (?:current )?font')  # matplotlib warns so
MOST_POINTS = 400_000  # over all bodies; more cost time and change no pixel
SAMPLES = 2000  # per body at most: about the width of the picture
FEWEST_SAMPLES = 200
FILM_OPTIONS = {
    'size': (960, 600),  # [pixel]
    'fps': 25.0,  # [Hz]
    'speed': None,
    'dark': False,
    'body': None,
    'follow': False,
}  # and what they are unless given


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare `view BAG -o FILE.png|FILE.html`."""
    parser.add_argument(
        'bag', nargs='?', metavar='BAG', help='bag directory or .mcap file; with --live also none'
    )
    parser.add_argument(
        '-o',
        '--output',
        metavar='FILE',
        type=Path,
        help='FILE.png: a picture; FILE.html: a page that plays the run, without network; '
        'FILE.gif, FILE.mp4: a film',
    )
    parser.add_argument(
        '--live',
        action='store_true',
        help='serve the page of a run that goes on, to browsers on this machine: of BAG, which is '
        'being written, or without BAG of the node that is running (needs ROS)',
    )
    parser.add_argument(
        '--port', type=int, default=0, metavar='N', help='of --live, default: any that is free'
    )
    parser.add_argument(
        '--namespace',
        metavar='NS',
        help='of the node for --live, default: the first that is found',
    )
    film = parser.add_argument_group('of a film')
    film.add_argument(
        '--size',
        type=_size,
        default=FILM_OPTIONS['size'],
        metavar='WxH',
        help='pixels, default 960x600',
    )
    film.add_argument(
        '--fps',
        type=float,
        default=FILM_OPTIONS['fps'],
        metavar='HZ',
        help='frames per second, default 25',
    )
    film.add_argument(
        '--speed',
        type=float,
        metavar='R',
        help='seconds of the run per second of film; default 1, for a long run what makes it 20 s',
    )
    film.add_argument('--dark', action='store_true', help='on a dark ground')
    film.add_argument('--body', metavar='NAME', help='the body that is selected')
    film.add_argument('--follow', action='store_true', help='the camera goes with that body')


def run(arguments: argparse.Namespace) -> int:
    """Draw the picture, the page or the film, or serve the page; returns the exit code."""
    if arguments.live:
        return _serve(arguments)
    if arguments.bag is None or arguments.output is None:
        raise UserError('give a BAG and -o FILE (.png, .html, .gif or .mp4), or --live')
    return _draw(arguments)


def _serve(arguments: argparse.Namespace) -> int:
    if arguments.output is not None:
        raise UserError('--live serves a page and writes none; leave out -o')
    _refuse_film_options(arguments, '--live')
    if not 0 <= arguments.port < 1 << 16:
        raise UserError(f'--port {arguments.port}; allowed: 0 (any that is free) to 65535')
    if arguments.bag is not None:
        return _serve_bag(arguments)
    from rigid_body_sim.ros.state_listener import StateListener
    from rigid_body_sim.view import live_server

    with StateListener(arguments.namespace) as listener:
        return live_server.serve(listener, port=arguments.port)


@reads_recording('bag')
def _serve_bag(arguments: argparse.Namespace) -> int:
    from rigid_body_sim.view import live_server
    from rigid_body_sim.view.bag_follower import BagFollower

    return live_server.serve(BagFollower(Path(arguments.bag)), port=arguments.port)


@reads_recording('bag')
def _draw(arguments: argparse.Namespace) -> int:
    _check_output(arguments.output)
    if arguments.output.suffix not in SUFFIXES:
        _refuse_film_options(arguments, str(arguments.output))
    settings = FilmSettings(
        arguments.size, arguments.fps, arguments.speed, arguments.dark, arguments.body,
        arguments.follow,
    )  # fmt: skip
    bag = Bag(arguments.bag)
    bodies = sum(name.endswith('/pose') for name in with_every_body(bag).topics)
    samples = max(FEWEST_SAMPLES, min(SAMPLES, MOST_POINTS // max(bodies, 1)))
    motion = drawn_part(read_motion(bag, samples=samples), name=str(bag.path))
    files = dict(bag.attachments)
    source = files.pop(SCENE, None)
    scene = None if source is None else load_scene(source, files=files)
    if scene is not None:
        motion = replace(motion, began=(scene_began(bag, scene) / 1e9,))
    energy = None if scene is None else energy_history(scene, motion, ending=bag.ending)
    title, about = bag.path.name if scene is None else scene.name, _about(bag)
    if arguments.output.suffix == '.png':
        figure = picture(
            motion,
            energy,
            title=', '.join(filter(None, (title, about))),
            caption=expected_outcome(scene),
            scene=scene,
        )
        content = _png(figure)
    else:
        page = playback_page(motion, scene, title=title, about=about, energy=energy, bag=bag)
        content = page.encode()
        if arguments.output.suffix in SUFFIXES:
            content = _film(page, arguments.output, settings, motion)
    with STOP.kept(), replacing(arguments.output) as new:  # half a picture looks like a whole one
        new.write_bytes(content)
    bodies = len(motion.tracks)
    print(f'{arguments.output}: {bodies} bod{"y" if bodies == 1 else "ies"}')
    return 0


def _refuse_film_options(arguments: argparse.Namespace, drawn: str) -> None:
    """Refuse what only a film can do."""
    for option, usual in FILM_OPTIONS.items():
        if getattr(arguments, option) != usual:
            raise UserError(
                f'{drawn}: --{option} is of a film, and changes nothing here; leave it out, or '
                'give -o FILE.gif or FILE.mp4'
            )


def _png(figure: Figure) -> bytes:
    """Draw a figure; say in one line which letters its font lacks."""
    image = BytesIO()
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter('always')
        figure.savefig(image, format='png', dpi=DOTS_PER_INCH)
    lacking: dict[str, None] = {}
    for said in found:
        glyph = LACKS.match(str(said.message))
        if glyph is None:
            warnings.warn(said.message, said.category, stacklevel=2)
        else:
            lacking[chr(int(glyph[1]))] = None
    if lacking:
        warning_printer('view')(
            f'the font of the picture lacks {"".join(lacking)!r}, in whose place boxes stand; '
            'draw a page (FILE.html), or say it in the scene in other letters'
        )
    return image.getvalue()


def _size(text: str) -> tuple[int, int]:
    """Read 960x600."""
    width, _, height = text.partition('x')
    return whole(width), whole(height)


def _film(page: str, output: Path, settings: FilmSettings, motion: RecordedMotion) -> bytes:
    names = [track.name for track in motion.tracks]
    if settings.body is not None and settings.body not in names:
        cure = choose_from(settings.body, names)
        raise UserError(f'--body {settings.body}: the bag has no such body{cure}')
    try:
        tempfile.gettempdir()
    except FileNotFoundError:
        raise UserError(
            f'{output}: its frames need a temporary folder, and none can be written (looked for: '
            '$TMPDIR, /tmp, /var/tmp, /usr/tmp, the present one); name one: TMPDIR=DIR'
        ) from None
    try:
        with tempfile.TemporaryDirectory() as folder:
            whole = Path(folder) / output.name
            film(page, whole, settings)
            return whole.read_bytes()
    except OSError as error:
        if error.errno not in FULL:
            raise
        raise not_written(
            Path(tempfile.gettempdir()),
            error,
            f'{output.name} is drawn there first: make room, or name another folder: TMPDIR=DIR',
        ) from error


def _check_output(output: Path) -> None:
    if output.suffix not in ('.png', '.html', *SUFFIXES):
        raise UserError(
            f'{output}: cannot draw {output.suffix or "without a suffix"}; '
            'give FILE.png, FILE.html, FILE.gif or FILE.mp4'
        )
    if output.suffix in SUFFIXES:
        need_tools(output)
    check_folder(output)


def _about(bag: Bag) -> str:
    """Integrator and tick length, as far as the bag tells."""
    parts = []
    values = RecordValues(bag.path, 'manifest', bag.manifest)
    if integrator := values.text('integrator', '').split():
        parts.append(f'integrator {integrator[0]}')
    if dt_ns := values.integer('dt_ns', 0, MOST_TIME, '0'):
        parts.append(f'dt = {dt_ns * 1e-9:g} s')
    if not bag.complete and bag.manifest:
        parts.append('run cut off')
    return ', '.join(parts)
