# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Draws a recorded run: trajectories, speeds, energy and the conservation laws as one PNG, or the
motion itself as a page that plays in a browser.
"""

from __future__ import annotations

import argparse
from io import BytesIO
from pathlib import Path

from rigid_body_sim.errors import UserError
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.recording.every_body import with_every_body
from rigid_body_sim.recording.mcap_scan import MOST_TIME
from rigid_body_sim.recording.new_output import check_folder
from rigid_body_sim.recording.record_values import RecordValues
from rigid_body_sim.runs.reading_guard import reads_recording
from rigid_body_sim.scene import load_scene
from rigid_body_sim.stop_signals import STOP
from rigid_body_sim.view.energy_history import energy_history
from rigid_body_sim.view.picture import picture
from rigid_body_sim.view.playback_page import playback_page
from rigid_body_sim.view.recorded_motion import read_motion

SUMMARY = 'draw a recorded run as a PNG, or play it in three dimensions on an HTML page'

SCENE = 'scene.yaml'
DOTS_PER_INCH = 130
MOST_POINTS = 400_000  # over all bodies; more cost time and change no pixel
SAMPLES = 2000  # per body at most: about the width of the picture
FEWEST_SAMPLES = 200


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare `view BAG -o FILE.png|FILE.html`."""
    parser.add_argument('bag', metavar='BAG', help='bag directory or .mcap file')
    parser.add_argument(
        '-o',
        '--output',
        metavar='FILE',
        required=True,
        type=Path,
        help='FILE.png: a picture; FILE.html: a page that plays the run, without network',
    )


@reads_recording('bag')
def run(arguments: argparse.Namespace) -> int:
    """Draw the picture or the page; returns the exit code."""
    _check_output(arguments.output)
    bag = Bag(arguments.bag)
    bodies = sum(name.endswith('/pose') for name in with_every_body(bag).topics)
    samples = max(FEWEST_SAMPLES, min(SAMPLES, MOST_POINTS // max(bodies, 1)))
    motion = read_motion(bag, samples=samples)
    files = dict(bag.attachments)
    source = files.pop(SCENE, None)
    scene = None if source is None else load_scene(source, files=files)
    energy = None if scene is None else energy_history(scene, motion, ending=bag.ending)
    title, about = bag.path.name if scene is None else scene.name, _about(bag)
    if arguments.output.suffix == '.html':
        page = playback_page(motion, scene, title=title, about=about, energy=energy, bag=bag)
        content = page.encode()
    else:
        figure = picture(motion, energy, title=', '.join(filter(None, (title, about))))
        image = BytesIO()
        figure.savefig(image, format='png', dpi=DOTS_PER_INCH)
        content = image.getvalue()
    with STOP.kept():  # half a picture looks like a whole one
        arguments.output.write_bytes(content)
    print(f'{arguments.output}: {len(motion.tracks)} bodies')
    return 0


def _check_output(output: Path) -> None:
    if output.suffix not in ('.png', '.html'):
        raise UserError(
            f'{output}: cannot draw {output.suffix or "without a suffix"}; '
            'give FILE.png or FILE.html'
        )
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
