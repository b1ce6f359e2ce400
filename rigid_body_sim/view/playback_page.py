# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
One self-contained HTML page that plays a recorded run in three dimensions.

The page asks no network for anything: the drawing library (three.js, as trimesh ships it), the
motion (float32, base64) and the picture of the whole run are inside. Between two recorded instants
the browser interpolates; what is recorded is shown as recorded.
"""

from __future__ import annotations

import base64
import io
import json
import zipfile
from html import escape
from importlib.resources import files
from string import Template

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.model.reach import reach
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.view.contact_arrows import read_arrows
from rigid_body_sim.view.drawn_shapes import DrawnShapes, drawn_planes
from rigid_body_sim.view.recorded_motion import RecordedMotion, Track

Array = NDArray[np.float64]

LARGEST = 32_000_000  # [byte] of motion in one page; more instants are left out evenly
BYTES_PER_POSE = 28
BALL = 0.012  # [-] radius of a point on the page, of the size of the whole
FAR, CLOSE_UP = 40.0, 9.0  # [-] in reaches of a body: so long a journey begins so near
ARROW, ARROW_OF_BODY = 0.15, 1.5  # [-] usual arrow at most: of the whole, of the largest reach
LIBRARY_ENDS = (
    'var camera,controls,scene,renderer,tracklight;'  # where the viewer of trimesh begins
)


def playback_page(
    motion: RecordedMotion, scene: Scene | None, *, title: str, picture: bytes,
    bag: Bag | None = None,
) -> str:  # fmt: skip
    """
    Write the page.

    scene   : shapes come from it; None: every body is drawn as a small ball
    picture : PNG of the whole run
    bag     : contact forces come from it, where it holds them
    """
    times, positions, orientations = _common_instants(motion)
    bodies = {} if scene is None else {body.name: body for body in scene.bodies}
    reaches = np.array([reach(bodies.get(track.name)) for track in motion.tracks])
    still = {body.name for body in bodies.values() if body.fixed and body.motion is None}
    moving = [track.name not in still for track in motion.tracks]
    centre, size = _extent(positions, reaches, moving)
    largest = float(reaches[moving].max(initial=0.0))
    ball = min(BALL * size, 0.3 * largest or np.inf)
    places = {name: place for place, name in enumerate(bodies)}
    touching = None if bag is None else read_arrows(bag, times, places)
    usual = min(ARROW * size, ARROW_OF_BODY * largest or np.inf)
    collides = scene is not None and scene.contact.get('mode', 'none') != 'none'
    drawn = DrawnShapes(ball=ball, meshes_collide=collides)
    run = {
        'times': times.tolist(),
        'bodies': [
            {
                'name': track.name,
                'fixed': not moves,
                'parts': drawn.parts(bodies.get(track.name)),
            }
            for track, moves in zip(motion.tracks, moving, strict=True)
        ],
        'forms': drawn.forms,
        'planes': drawn_planes(scene),
        'numbers': _packed(positions, orientations),
        'speeds': [_magnitude(track, track.velocity, times) for track in motion.tracks],
        'spins': [_magnitude(track, track.angular_velocity, times) for track in motion.tracks],
        'centre': centre.tolist(),
        'size': size,
        'contacts': None if touching is None else touching.drawn(usual),
        'close_up': CLOSE_UP * largest if size > FAR * largest > 0.0 else None,
    }
    return Template(
        (files('rigid_body_sim.view') / 'playback.html').read_text('utf-8')
    ).substitute(
        title=escape(title),
        picture=base64.b64encode(picture).decode(),
        three=_drawing_library(),
        run=json.dumps(run, separators=(',', ':')).replace('<', '\\u003c'),
    )


def _drawing_library() -> str:
    """Take three.js with its mouse controls out of the viewer that trimesh ships."""
    archive = (files('trimesh') / 'resources' / 'templates' / 'viewer.zip').read_bytes()
    with zipfile.ZipFile(io.BytesIO(archive)) as bundle:
        viewer = bundle.read('viewer.html.template').decode('utf-8')
    script = viewer.partition('<script>')[2]
    library, found, _ = script.partition(LIBRARY_ENDS)
    if not found:
        raise UserError(
            'the installed trimesh ships another viewer than the one this page takes three.js '
            'from; install the version named in requirements/runtime.txt, or write a .png'
        )
    return library


def _common_instants(motion: RecordedMotion) -> tuple[Array, Array, Array]:
    """Times (k,), positions (k, n, 3) and orientations (k, n, 4) of all bodies together."""
    longest = max(motion.tracks, key=lambda track: len(track.time))
    most = max(2, LARGEST // (BYTES_PER_POSE * len(motion.tracks)))
    every = -(-len(longest.time) // most)
    times = longest.time[::every]
    positions = np.empty((len(times), len(motion.tracks), 3))
    orientations = np.empty((len(times), len(motion.tracks), 4))
    for i, track in enumerate(motion.tracks):
        nearest = np.clip(np.searchsorted(track.time, times - 1e-9), 0, len(track.time) - 1)
        positions[:, i] = track.position[nearest]
        orientations[:, i] = track.orientation[nearest]
    return times, positions, orientations


def _packed(positions: Array, orientations: Array) -> str:
    together = np.concatenate((positions, orientations), axis=2).astype('<f4')
    return base64.b64encode(together.tobytes()).decode()


def _magnitude(track: Track, vectors: Array, times: Array) -> list[float] | None:
    if not len(vectors):
        return None
    nearest = np.clip(np.searchsorted(track.twist_time, times - 1e-9), 0, len(vectors) - 1)
    return [float(f'{v:.5g}') for v in np.linalg.norm(vectors[nearest], axis=1)]


def _extent(positions: Array, reach: Array, moving: list[bool]) -> tuple[Array, float]:
    """Centre (3,) [m] and size [m] of the space in which bodies move."""
    chosen = np.array(moving if any(moving) else [True] * len(moving))
    low = (positions - reach[:, None])[:, chosen].min(axis=(0, 1))
    high = (positions + reach[:, None])[:, chosen].max(axis=(0, 1))
    return 0.5 * (low + high), float(np.linalg.norm(high - low)) or 1.0
