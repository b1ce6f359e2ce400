# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The page of a run as a film: a headless Chromium draws each frame, Pillow (GIF) or ffmpeg (MP4)
joins them.

A frame shows the state at its own time, however long it takes to draw: the film is as smooth on a
slow machine.
"""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from tqdm import tqdm

from rigid_body_sim.errors import RunError, UserError
from rigid_body_sim.view import chromium

SUFFIXES = ('.gif', '.mp4')
LONGEST = 20.0  # [s] of film, unless another speed is asked for
SPEEDS = (5.0, 2.0, 1.0)  # times a power of ten
MOST_FRAMES = 3000
PALETTE = 128  # colours of a GIF: more are not to be told apart in such pictures, and cost bytes
LEAST_SIDE, MOST_SIDE = 120, 4096  # [pixel]
READY = "document.body.dataset.state !== 'loading'"


@dataclass(frozen=True)
class FilmSettings:
    """
    How a film looks.

    size   : width and height [pixel], even: video needs that
    rate   : [Hz] frames per second
    speed  : [-] seconds of the run per second of film; None: its own, or that of a film of 20 s
    dark   : on a dark ground
    body   : which one is selected; None: the first that can move
    follow : the camera goes with it
    """

    size: tuple[int, int] = (960, 600)
    rate: float = 25.0
    speed: float | None = None
    dark: bool = False
    body: str | None = None
    follow: bool = False

    def __post_init__(self) -> None:
        if any(side % 2 or not LEAST_SIDE <= side <= MOST_SIDE for side in self.size):
            raise UserError(
                f'--size {self.size[0]}x{self.size[1]}; allowed: even numbers of pixels from '
                f'{LEAST_SIDE} to {MOST_SIDE}'
            )
        if not 1.0 <= self.rate <= 120.0:
            raise UserError(f'--fps {self.rate:g}; allowed: 1 to 120 frames per second')
        if self.speed is not None and not 1e-6 <= self.speed <= 1e6:
            raise UserError(f'--speed {self.speed:g}; allowed: 1e-6 to 1e6')


def need_tools(output: Path) -> None:
    """UserError that says what is missing for a film of this kind."""
    if chromium.find() is None:
        raise UserError(
            f'{output}: the frames of a film are drawn by a browser, and none is here: apt-get '
            f'install chromium (looked for: {", ".join(chromium.NAMES)}); .html and .png need none'
        )
    if output.suffix == '.mp4' and shutil.which('ffmpeg') is None:
        raise UserError(
            f'{output}: ffmpeg, which writes MP4, is not on the path: apt-get install ffmpeg; '
            f'or give {output.with_suffix(".gif").name}, which needs none'
        )
    if output.suffix == '.gif':
        import PIL.Image  # noqa: F401  (its absence is named as that of any package)


def film(page: str, output: Path, settings: FilmSettings) -> int:
    """Write a film of a page to a .gif or .mp4 file; returns the number of frames."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / 'run.html'
        file.write_text(page, encoding='utf-8')
        with chromium.page(Path(folder) / 'profile') as tab:
            times = _open(tab, file, settings)
            frames = _frames(tab, times)
            if output.suffix == '.mp4':
                _write_mp4(frames, output, settings.rate)
            else:
                _write_gif(frames, output, settings.rate)
    return len(times)


def _open(tab: chromium.Page, file: Path, settings: FilmSettings) -> list[float]:
    """Open the page as a film shows it; returns the times of the frames."""
    wishes = f'film&paused&theme={"dark" if settings.dark else "light"}'
    if settings.body is not None:
        wishes += f'&body={settings.body}'
    if settings.follow:
        wishes += '&follow'
    width, height = settings.size
    tab.open(f'{file.as_uri()}#{wishes}', width=width, height=height)
    tab.wait_for(READY)
    if tab.evaluate('document.body.dataset.state') != 'ready':
        said = tab.evaluate("document.getElementById('message').textContent")
        raise RunError(f'the browser cannot draw the run: {said}')
    begin, end = tab.evaluate('[view.run.begin, view.run.end]')
    speed = settings.speed or _speed(end - begin)
    count = round((end - begin) / speed * settings.rate) + 1
    if count > MOST_FRAMES:
        raise UserError(
            f'{count} frames at speed {speed:g}; a film has at most {MOST_FRAMES}: give a larger '
            '--speed or a smaller --fps'
        )
    return np.linspace(begin, end, max(count, 2)).tolist()


def _speed(length: float) -> float:
    """One, or a round number at which a long run is over in 20 s."""
    if length <= LONGEST:
        return 1.0
    wanted = length / LONGEST
    power = 10.0 ** np.floor(np.log10(wanted))
    return float(min(s * power for s in (*SPEEDS, 10.0) if s * power >= wanted))


def _frames(tab: chromium.Page, times: list[float]) -> Iterator[bytes]:
    """Yield each frame as PNG."""
    for time in tqdm(times, unit=' frames', disable=None):
        tab.evaluate(f'view.seek({time!r})')
        tab.settle()
        yield tab.picture()


def _write_mp4(frames: Iterable[bytes], output: Path, rate: float) -> None:
    words = ['ffmpeg', '-y', '-loglevel', 'error', '-f', 'image2pipe', '-framerate', f'{rate:g}']
    words += ['-i', '-', '-pix_fmt', 'yuv420p', '-movflags', '+faststart', str(output)]
    with subprocess.Popen(
        words, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE
    ) as process:
        assert process.stdin is not None and process.stderr is not None
        try:
            for frame in frames:
                process.stdin.write(frame)
            process.stdin.close()
        except BrokenPipeError:
            pass  # it says why below
        said = process.stderr.read().decode('utf-8', 'replace').strip()
    if process.returncode:
        raise RunError(f'{output}: ffmpeg failed: {said or f"exit code {process.returncode}"}')


def _write_gif(frames: Iterable[bytes], output: Path, rate: float) -> None:
    """Write all frames with the colours of some of them, so that what stays costs nothing."""
    from PIL import Image

    pictures: list[Any] = [Image.open(BytesIO(frame)).convert('RGB') for frame in frames]
    some = pictures[:: max(1, len(pictures) // 6)]
    strip = Image.new('RGB', (some[0].width, sum(each.height for each in some)))
    for place, each in enumerate(some):
        strip.paste(each, (0, place * each.height))
    colors = strip.quantize(PALETTE, method=Image.Quantize.MEDIANCUT)
    flat = [each.quantize(palette=colors, dither=Image.Dither.NONE) for each in pictures]
    # a GIF counts hundredths of a second
    flat[0].save(
        output, save_all=True, append_images=flat[1:], duration=round(100.0 / rate) * 10, loop=0
    )
