# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Attacks recordings: damages copies of small bags in every way that it knows, lets the verbs read
them, and counts who does not bear it.

    python tools/damage_bags.py --cases 5000 --flips 3000 --seed 1

The laws, for each damaged bag:
    a verb ends with one of its exit codes, within the time limit, never with a traceback
    what it says holds no control characters, and an error is one line
    a bag that `bag check` calls whole replays; what `bag recover` saves, too
    (of a forgery, whose checksums were all made right again, `replay` may say that it differs)
and for a single flipped bit, anywhere in the directory of a bag:
    `bag check` or `replay` finds it, or what they and `bag info` print is what it was

Exit code 1 if any law was broken; the damaged bags that broke it are kept (--keep DIR).
"""

from __future__ import annotations

import argparse
import io
import json
import os
import random
import resource
import shutil
import signal
import struct
import sys
import tempfile
import time
import traceback
import zlib
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, redirect_stderr, redirect_stdout, suppress
from pathlib import Path
from typing import Any, NamedTuple

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
if __name__ == '__main__':  # so few ticks are not worth a compilation
    os.environ.setdefault('RIGID_BODY_SIM_COMPILE', '0')

from rigid_body_sim.__main__ import main
from rigid_body_sim.recording import mcap_file
from rigid_body_sim.recording.seal import sealed

COMMANDS = """time,body,kind,frame,fx,fy,fz,tx,ty,tz
0.005,box,wrench,world,1,0,0,0,0,0
0.010,box,torque,body,0,0,0,0.01,0,0
0.015,ball,impulse,world,0.3,0,0,0,0,0
"""
BOUNCES = """version: 1
name: bounces
dt: 0.004
gravity: [0, 0, -9.81]
contact: {mode: event}
bodies:
  - {name: floor, shape: {type: plane, normal: [0, 0, 1]}}
  - name: ball
    mass: 1.0
    restitution: 0.8
    shape: {type: sphere, radius: 0.05}
    initial: {position: [0, 0, 0.051], velocity: [1, 0, -1]}
  - name: box
    mass: 1.0
    restitution: 0.5
    shape: {type: box, size: [0.1, 0.1, 0.1]}
    initial: {position: [0.3, 0, 0.09], velocity: [0, 0, -2], angular_velocity: [3, 1, 2]}
"""
WRITTEN = {'bounces': BOUNCES}  # scenes that are not shipped
SOURCES = (
    ('two_bodies', '--duration', '0.03', '--publish-rate', '200'),
    ('oscillator', '--duration', '0.05'),
    ('rolling_sphere', '--duration', '0.02', '--publish-rate', '200', '--contacts'),
    ('bounces', '--duration', '0.06'),
)
MEMORY = 6 << 30  # [bytes] of address space
ALLOWED = {0, 1, 2, 3}
DIFFERS = 3
TOLD_EVERY = 250  # bags
WAITING = 6  # times the limit: a busy machine is no law broken
KNOWN = ('rigid_body_sim ', 'usage: ')  # how our lines on standard error begin
MAGIC = mcap_file.MAGIC
Parts = list[tuple[int, bytes]]  # opcode and content of each record of a data section


class Outcome(NamedTuple):
    """What a verb did: exit code, None where it raised or took too long, and what it said."""

    code: int | None
    out: str
    err: str


class TooLong(BaseException):
    """The time limit of a call has passed."""


@contextmanager
def time_limit(seconds: float) -> Iterator[None]:
    """Raise TooLong after some seconds of processor time, or far more of waiting."""

    def ring(*_: object) -> None:
        raise TooLong

    alarms = (
        (signal.ITIMER_PROF, signal.SIGPROF, seconds),
        (signal.ITIMER_REAL, signal.SIGALRM, WAITING * seconds),
    )
    for timer, number, limit in alarms:
        signal.signal(number, ring)
        signal.setitimer(timer, limit)
    try:
        yield
    finally:
        for timer, _, _ in alarms:
            signal.setitimer(timer, 0)


def call(*words: object, limit: float = 20.0) -> Outcome:
    """Run a verb in this process."""
    out, err = io.StringIO(), io.StringIO()
    code: int | None = None
    with redirect_stdout(out), redirect_stderr(err):
        try:
            with time_limit(limit):
                code = main([str(word) for word in words])
        except SystemExit as stop:
            code = stop.code if isinstance(stop.code, int) else 2
        except TooLong:
            err.write(f'took longer than {limit:g} s')
        except BaseException:  # the law that is looked after: nothing gets here
            traceback.print_exc(file=err)
    return Outcome(code, out.getvalue(), err.getvalue())


def broken_laws(what: str, outcome: Outcome) -> list[str]:
    """Name what a verb did wrong, whatever it was given."""
    laws = []
    if outcome.code is None:
        last = outcome.err.strip().splitlines()
        place = [line for line in last if 'rigid_body_sim' in line and 'File' in line][-1:]
        where = place[0].split('rigid_body_sim/')[-1] if place else ''
        return [f'{what}: {last[-1][:200] if last else "no word"} ({where})']
    if outcome.code not in ALLOWED:
        laws.append(f'{what}: exit code {outcome.code}')
    lines = [line for line in outcome.err.splitlines() if line.strip()]
    strange = [line for line in lines if not line.startswith(KNOWN) and '\r' not in line]
    if strange:
        laws.append(f'{what}: says {strange[0][:200]!r}')
    text = outcome.out + outcome.err
    if any(not c.isprintable() for c in text if c not in '\n\t\r'):
        laws.append(f'{what}: a control character reached the terminal')
    return laws


# ---- files as records


def records(data: bytes) -> Parts:
    """Take the data section of a good file apart."""
    found, place = [], len(MAGIC)
    while True:
        opcode, length = struct.unpack_from('<BQ', data, place)
        if opcode == mcap_file.DATA_END:
            return found
        found.append((opcode, data[place + 9 : place + 9 + length]))
        place += 9 + length


def text_at(content: bytes, place: int) -> tuple[str, int]:
    """Read a string with its length before it; where it ends."""
    (length,) = struct.unpack_from('<I', content, place)
    return content[place + 4 : place + 4 + length].decode(), place + 4 + length


def text(value: str) -> bytes:
    """Write a string with its length before it."""
    content = value.encode('utf-8', 'replace')
    return struct.pack('<I', len(content)) + content


def metadata(content: bytes) -> tuple[str, dict[str, str]]:
    """Read a metadata record."""
    name, place = text_at(content, 0)
    place, pairs = place + 4, {}
    while place < len(content):
        key, place = text_at(content, place)
        pairs[key], place = text_at(content, place)
    return name, pairs


def metadata_content(name: str, pairs: dict[str, str]) -> bytes:
    """Write a metadata record."""
    body = b''.join(text(key) + text(value) for key, value in pairs.items())
    return text(name) + struct.pack('<I', len(body)) + body


def packed(parts: Parts) -> bytes:
    """
    Put a file together from its data section, with right CRCs and a right summary, as far as its
    records can be read.
    """
    data, summary, places = bytearray(MAGIC), bytearray(), Counter[int]()
    counts, times = Counter[int](), []
    for opcode, content in parts:
        place, size = len(data), 9 + len(content)
        data += struct.pack('<BQ', opcode, len(content)) + content
        places[opcode] += 1
        with suppress(struct.error, UnicodeDecodeError):
            if opcode in (mcap_file.SCHEMA, mcap_file.CHANNEL):
                summary += struct.pack('<BQ', opcode, len(content)) + content
            elif opcode == mcap_file.METADATA:
                entry = struct.pack('<QQ', place, size) + text(text_at(content, 0)[0])
                summary += struct.pack('<BQ', mcap_file.METADATA_INDEX, len(entry)) + entry
            elif opcode == mcap_file.ATTACHMENT:
                name, after = text_at(content, 16)
                kind, after = text_at(content, after)
                entry = struct.pack('<QQ', place, size) + content[:16] + content[after : after + 8]
                entry += text(name) + text(kind)
                summary += struct.pack('<BQ', mcap_file.ATTACHMENT_INDEX, len(entry)) + entry
            elif opcode == mcap_file.CHUNK:
                start, end, whole = struct.unpack_from('<QQQ', content)
                entry = struct.pack('<QQQQIQ', start, end, place, size, 0, 0) + text('')
                entry += struct.pack('<QQ', whole, whole)
                summary += struct.pack('<BQ', mcap_file.CHUNK_INDEX, len(entry)) + entry
                times += [start, end]
                for channel in messages_of(content):
                    counts[channel] += 1
    table = b''.join(struct.pack('<HQ', *item) for item in sorted(counts.items()))
    statistics = struct.pack(
        '<QHIIIIQQI',
        counts.total(),
        places[mcap_file.SCHEMA],
        places[mcap_file.CHANNEL],
        places[mcap_file.ATTACHMENT],
        places[mcap_file.METADATA],
        places[mcap_file.CHUNK],
        min(times, default=0),
        max(times, default=0),
        len(table),
    )
    summary += struct.pack('<BQ', mcap_file.STATISTICS, len(statistics) + len(table))
    summary += statistics + table
    data += struct.pack('<BQI', mcap_file.DATA_END, 4, zlib.crc32(data))
    footer = struct.pack('<BQQQ', mcap_file.FOOTER, 20, len(data), 0)
    tail = bytes(summary) + footer
    return bytes(data) + tail + struct.pack('<I', zlib.crc32(tail)) + MAGIC


def messages_of(chunk: bytes) -> Iterator[int]:
    """Channel ids of the messages in an uncompressed chunk."""
    (length,) = struct.unpack_from('<I', chunk, 28)
    place = 32 + length + 8
    while place + 9 <= len(chunk):
        opcode, size = struct.unpack_from('<BQ', chunk, place)
        if opcode == mcap_file.MESSAGE and size >= 2 and place + 11 <= len(chunk):
            yield struct.unpack_from('<H', chunk, place + 9)[0]
        place += 9 + size


def repaired(opcode: int, content: bytes) -> bytes:
    """Put the right CRC into a changed chunk or attachment."""
    if opcode == mcap_file.CHUNK and len(content) > 32:
        (length,) = struct.unpack_from('<I', content, 28)
        if length == 0:
            return content[:24] + struct.pack('<I', zlib.crc32(content[40:])) + content[28:]
    if opcode == mcap_file.ATTACHMENT and len(content) > 4:
        return content[:-4] + struct.pack('<I', zlib.crc32(content[:-4]))
    return content


# ---- kinds of damage: each changes the directory of a bag


def scratch_bytes(data: bytes, rng: random.Random) -> bytes:
    """Change bytes as bad media and bad transfers do."""
    changed = bytearray(data)
    place, size = rng.randrange(len(data)), 1 + int(2 ** rng.uniform(0, 12))
    match rng.randrange(6):
        case 0:
            for _ in range(rng.randint(1, 6)):
                changed[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
        case 1:
            del changed[place:]
        case 2:
            del changed[place : place + size]
        case 3:
            changed[place:place] = rng.randbytes(size)
        case 4:
            changed[place : place + size] = bytes(len(changed[place : place + size]))
        case _:
            changed[place : place + 8] = struct.pack('<Q', hostile_integer(rng))
    return bytes(changed)


def raw(directory: Path, rng: random.Random) -> None:
    """Scratch a file of the bag."""
    file = rng.choice(sorted(directory.iterdir()) + list(directory.glob('*.mcap')) * 3)
    file.write_bytes(scratch_bytes(file.read_bytes(), rng))


def record(directory: Path, rng: random.Random) -> None:
    """Lose, double, move or change records; CRCs and summary are right again."""
    file = mcap_of(directory)
    parts = records(file.read_bytes())
    for _ in range(rng.choice((1, 1, 1, 2, 4))):
        at = rng.randrange(1, len(parts))
        opcode, content = parts[at]
        match rng.randrange(7):
            case 0:
                del parts[at]
            case 1:
                parts.insert(rng.randrange(1, len(parts)), parts[at])
            case 2:
                other = rng.randrange(1, len(parts))
                parts[at], parts[other] = parts[other], parts[at]
            case 3:
                parts[at] = (rng.randrange(1, 16), content)
            case _:
                changed = scratch_bytes(content, rng) if content else b''
                if rng.random() < 0.6 and len(content) > 8:  # keep its length: one field
                    grown = bytearray(content)
                    where = rng.randrange(len(content) - 4)
                    grown[where : where + 4] = struct.pack(
                        '<I', rng.choice((0, 1, 65535, rng.getrandbits(32)))
                    )
                    changed = bytes(grown)
                parts[at] = (opcode, repaired(opcode, changed))
        if len(parts) < 3:
            break
    file.write_bytes(packed(parts))


def manifest(directory: Path, rng: random.Random) -> None:
    """Put hostile values into what the bag says of its run."""
    claims(directory, rng, forged=False)


def forgery(directory: Path, rng: random.Random) -> None:
    """The same with its seal made right again: then `replay` alone can tell."""
    claims(directory, rng, forged=True)


def claims(directory: Path, rng: random.Random, *, forged: bool) -> None:
    """Change what manifest, ending or recovery record say."""
    file = mcap_of(directory)
    parts = records(file.read_bytes())
    ours = [
        at
        for at, (opcode, content) in enumerate(parts)
        if opcode == mcap_file.METADATA and metadata(content)[0] != 'rosbag2'
    ]
    at = rng.choice(ours[:1] * 3 + ours)
    name, pairs = metadata(parts[at][1])
    for _ in range(rng.choice((1, 1, 2, 5))):
        key = rng.choice(sorted(pairs))
        if rng.random() < 0.1:
            del pairs[key]
            pairs[hostile_text(rng)] = ''
        else:
            pairs[key] = hostile_value(rng, pairs[key])
    pairs = sealed(pairs) if forged else pairs
    parts[at] = (mcap_file.METADATA, metadata_content(name, pairs))
    file.write_bytes(packed(parts))


def yaml_of(directory: Path, rng: random.Random) -> None:
    """Put hostile values into metadata.yaml."""
    file = directory / 'metadata.yaml'
    lines = file.read_text().splitlines()
    at = rng.randrange(len(lines))
    match rng.randrange(5):
        case 0:
            bomb = ['a0: &a0 {x: 1}']
            bomb += [
                f'a{n}: &a{n} {{<<: [{", ".join([f"*a{n - 1}"] * 10)}]}}' for n in range(1, 10)
            ]
            lines[:0] = bomb
        case 1:
            lines[:0] = ['a: ' + '[' * 5000 + ']' * 5000]
        case 2:
            del lines[at]
        case _:
            head, colon, _ = lines[at].partition(':')
            value = rng.choice(
                (hostile_text(rng), str(hostile_integer(rng)), '[]', '{}', '~', '1e400')
            )
            lines[at] = (
                f'{head}{colon or ":"} {json.dumps(value) if rng.random() < 0.5 else value}'
            )
    file.write_text('\n'.join(lines))


def bomb(directory: Path, rng: random.Random) -> None:
    """Replace a chunk by one that claims, or unpacks to, far more than it is."""
    import lz4.frame
    import zstandard

    file = mcap_of(directory)
    parts = records(file.read_bytes())
    chunks = [at for at, (opcode, _) in enumerate(parts) if opcode == mcap_file.CHUNK]
    size = rng.choice((1 << 20, 1 << 24, 100_000_000))
    content = bytes(size)
    kind, pack = rng.choice(
        (('zstd', zstandard.ZstdCompressor().compress), ('lz4', lz4.frame.compress))
    )
    claimed = rng.choice((size, 100, 2**40, 2**63, size + 1))
    crc = rng.choice((0, zlib.crc32(content)))
    small = pack(content)
    chunk = struct.pack('<QQQI', 0, 10, claimed, crc) + text(kind)
    parts[rng.choice(chunks)] = (
        mcap_file.CHUNK,
        chunk + struct.pack('<Q', len(small)) + small,
    )
    file.write_bytes(packed(parts))


KINDS: dict[str, tuple[Callable[[Path, random.Random], None], int]] = {
    'raw': (raw, 40),
    'record': (record, 30),
    'manifest': (manifest, 5),
    'forgery': (forgery, 20),
    'metadata.yaml': (yaml_of, 4),
    'bomb': (bomb, 1),
}


def hostile_integer(rng: random.Random) -> int:
    """Return a number at some border."""
    near = rng.choice((0, 1, 2**31, 2**32, 2**53, 2**62, 2**63, 2**64 - 1, 4_000_000_000, 10**12))
    return max(0, min(2**64 - 1, near + rng.randint(-2, 2)))


def hostile_text(rng: random.Random) -> str:
    """Return a text that somebody might not bear."""
    return rng.choice(
        (
            '',
            ' ',
            '\x1b[2J\x1b]0;owned\x07',
            'a\nb\r\x00c',
            '\u202egnp.exe',
            'x' * 5000,
            '../../etc/passwd',
            '$x_{ $',
            '[' * 3000,
            '{"a": ' * 500,
            '1' * 5000,
            'é\udcff'.encode('utf-8', 'replace').decode(),
            '%s %n {0}',
        )
    )


def hostile_value(rng: random.Random, old: str) -> str:
    """Return a manifest value of any type and size, or one near what was there."""
    scalar: list[Any] = [
        None,
        True,
        -1,
        0,
        1.5,
        1e308,
        'x',
        [],
        {},
        [[]],
        {'mode': []},
        {'a': None},
    ]
    match rng.randrange(6):
        case 0:
            return hostile_text(rng)
        case 1:
            return str(hostile_integer(rng) * rng.choice((1, 1, -1)))
        case 2:
            return json.dumps(rng.choice(scalar))
        case 3:
            return json.dumps([rng.choice(scalar) for _ in range(rng.randint(1, 6))])
        case 4:
            return rng.choice(('NaN', '[NaN, 0, 0]', '1e400', '[1e999]', 'Infinity', '-0'))
        case _:
            place = rng.randrange(len(old) + 1)
            return old[:place] + rng.choice('0123456789 -.e[]{}",x') + old[place + 1 :]


# ---- trials


def mcap_of(directory: Path) -> Path:
    """Return the file of a bag."""
    return next(directory.glob('*.mcap'))


def make_sources(place: Path, scenes: Sequence[Sequence[str]]) -> list[Path]:
    """Record the bags that will be damaged; a scene with its settings each."""
    commands = place / 'commands.csv'
    commands.write_text(COMMANDS)
    bags = []
    for scene, *settings in scenes:
        words = [*settings, *(['--commands', commands] if scene == 'two_bodies' else [])]
        bag = place / f'source_{len(bags)}'
        source = scene
        if scene in WRITTEN:
            source = place / f'{scene}.yaml'
            source.write_text(WRITTEN[scene])
        outcome = call('simulate', source, '-o', bag, *words, limit=300)
        if outcome.code != 0:
            raise SystemExit(f'cannot record {scene}: {outcome.err}')
        bags.append(bag)
    return bags


def trial(
    bag: Path, source: Path, work: Path, allowed: set[int], *, slow: bool
) -> tuple[list[str], str]:
    """
    Let every verb read a damaged bag; the laws broken, and what became of the bag.

    allowed : how `replay` may end where `bag check` calls a bag whole
    """
    laws = []

    def law(name: str, *words: object) -> int | None:
        outcome = call(*words)
        laws.extend(broken_laws(name, outcome))
        return outcome.code

    checked = law('check', 'bag', 'check', bag)
    law('info', 'bag', 'info', bag)
    law('diff', 'bag', 'diff', source, bag)
    replayed = law('replay', 'replay', bag)
    if checked == 0 and replayed not in allowed:
        laws.append(f'check says whole, replay exits with {replayed}')
    saved = work / 'saved'
    if law('recover', 'bag', 'recover', bag, '-o', saved) == 0:
        if law('check of the recovered', 'bag', 'check', saved) == 0:
            again = law('replay of the recovered', 'replay', saved)
            if again not in allowed:
                laws.append(f'check calls the recovered bag whole, replay exits with {again}')
        elif slow:
            law('replay of the recovered', 'replay', saved)
    if slow:
        law('replay --dt', 'replay', bag, '--dt', '0.0005')
        law('inverse', 'inverse', bag, '-o', work / 'inverse')
        law('export', 'export', bag, '-o', work / 'states.csv')
        law('export --impacts', 'export', bag, '--impacts', '-o', work / 'impacts.csv')
        law('view', 'view', bag, '-o', work / 'view.png')
        law('view', 'view', bag, '-o', work / 'view.html')
    return laws, 'whole' if checked == 0 else 'found'


def flip(bag: Path, source: Path, expected: dict[str, str]) -> tuple[list[str], str]:
    """Judge a bag with one flipped bit."""
    outcome = call('bag', 'check', bag)
    laws = broken_laws('check', outcome)
    if outcome.code != 0:
        return laws, 'found by check'
    replayed = call('replay', bag)
    laws += broken_laws('replay', replayed)
    if replayed.code != 0:
        return [*laws, 'check says whole, replay does not'], 'found by replay'
    said = {'check': outcome.out, 'replay': replayed.out, 'info': call('bag', 'info', bag).out}
    changed = [verb for verb in said if said[verb].replace(str(bag), '') != expected[verb]]
    return [*laws, *(f'{verb} prints something else' for verb in changed)], 'changes nothing'


def said_of(bag: Path) -> dict[str, str]:
    """What the verbs print of a good bag, without its name."""
    words = {'check': ('bag', 'check'), 'replay': ('replay',), 'info': ('bag', 'info')}
    return {verb: call(*w, bag).out.replace(str(bag), '') for verb, w in words.items()}


class Attack:
    """
    Counts outcomes and broken laws; keeps the bags that broke one.

    place  : where to work
    keep   : where to; None: they are lost
    seed   : of all cases; case k depends on (seed, k) alone
    scenes : what is recorded to be damaged
    """

    def __init__(
        self,
        place: Path,
        *,
        seed: int,
        keep: Path | None = None,
        scenes: Sequence[Sequence[str]] = SOURCES,
    ) -> None:
        self.sources = make_sources(place, scenes)
        self.outcomes: Counter[str] = Counter()
        self.broken: Counter[str] = Counter()
        self.slowest = 0.0
        self._place = place
        self._keep = keep
        self._seed = seed

    def run(self, cases: Iterable[int], flips: Iterable[int]) -> None:
        """Try damaged bags, and flipped bits."""
        for case in cases:
            self.damaged(case)
        expected = {source: said_of(source) for source in self.sources}
        for case in flips:
            self.flipped(case, expected)

    def damaged(self, case: int) -> None:
        """Damage a bag in some way and try every verb on it."""
        rng = random.Random(f'{self._seed} {case}')
        kinds = list(KINDS)
        kind = rng.choices(kinds, [KINDS[name][1] for name in kinds])[0]
        with self._copy(rng) as (bag, source, work):
            KINDS[kind][0](bag, rng)
            allowed = {0, DIFFERS} if kind == 'forgery' else {0}
            laws, outcome = trial(bag, source, work, allowed, slow=rng.random() < 0.03)
            self._note(f'{kind}: {outcome}', laws, f'damaged_{case}', bag)

    def flipped(self, case: int, expected: dict[Path, dict[str, str]]) -> None:
        """Flip one bit of a bag."""
        rng = random.Random(f'{self._seed} flip {case}')
        with self._copy(rng) as (bag, source, _):
            files = sorted(bag.iterdir())
            file = rng.choices(files, [each.stat().st_size for each in files])[0]
            data = bytearray(file.read_bytes())
            data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
            file.write_bytes(data)
            laws, outcome = flip(bag, source, expected[source])
            self._note(f'flip: {outcome}', laws, f'flip_{case}', bag)

    @contextmanager
    def _copy(self, rng: random.Random) -> Iterator[tuple[Path, Path, Path]]:
        source = rng.choice(self.sources)
        work = Path(tempfile.mkdtemp(dir=self._place))
        started = time.monotonic()
        try:
            yield Path(shutil.copytree(source, work / source.name)), source, work
        finally:
            self.slowest = max(self.slowest, time.monotonic() - started)
            shutil.rmtree(work, ignore_errors=True)

    def _note(self, outcome: str, laws: list[str], name: str, bag: Path) -> None:
        self.outcomes[outcome] += 1
        if self.outcomes.total() % TOLD_EVERY == 0:
            print(f'{self.outcomes.total()} bags: {dict(self.outcomes)}', file=sys.stderr)
        for law in laws:
            self.broken[law] += 1
            print(f'{name}: {law}', file=sys.stderr)
        if laws and self._keep is not None:
            shutil.copytree(bag, self._keep / name, dirs_exist_ok=True)


def attack(cases: range, flips: range, seed: int, *, keep: Path | None = None) -> Attack:
    """Try so many damaged bags and so many flipped bits."""
    with tempfile.TemporaryDirectory() as place:
        found = Attack(Path(place), seed=seed, keep=keep)
        found.run(cases, flips)
    return found


def run() -> int:
    """Attack as the command line says; print the counts."""
    parser = argparse.ArgumentParser(description=__doc__.split('\n\n')[0])
    parser.add_argument('--cases', type=int, default=500, help='damaged bags')
    parser.add_argument('--flips', type=int, default=300, help='bags with one flipped bit')
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--first', type=int, default=0, help='number of the first case')
    parser.add_argument('--keep', type=Path, help='where to keep bags that broke a law')
    words = parser.parse_args()
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    started = time.monotonic()
    first = words.first
    cases, flips = (range(first, first + count) for count in (words.cases, words.flips))
    found = attack(cases, flips, words.seed, keep=words.keep)
    for outcome, count in sorted(found.outcomes.items()):
        print(f'{count:7d}  {outcome}')
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(
        f'{found.outcomes.total()} bags in {time.monotonic() - started:.0f} s, slowest '
        f'{found.slowest:.1f} s, {memory:.0f} MiB; laws broken: {found.broken.total()}'
    )
    for law, count in found.broken.most_common():
        print(f'{count:7d}  {law}')
    return 1 if found.broken else 0


if __name__ == '__main__':
    sys.exit(run())
