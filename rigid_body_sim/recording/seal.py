# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Seals on the records that say what a run was, how it ended, and how it was recovered.

MCAP puts no checksum on its metadata records, and a file that was cut off has none over the whole.
So each record of ours carries the SHA-256 of its own pairs: damage is found wherever the record is
read, also in a torn file and in one that another tool has packed anew. It is no signature: whoever
can write the record can seal it.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping

SEAL = 'record_sha256'
MESSAGES_CRC = 'messages_crc32'  # in an ending: CRC-32 of all message records before it
ATTACHMENTS = 'attachments_sha256'  # in a manifest: file name -> SHA-256, as JSON
_CHECKS = (SEAL, MESSAGES_CRC, ATTACHMENTS)


def sealed(content: Mapping[str, str]) -> dict[str, str]:
    """Return the pairs and, last, their seal."""
    pairs = {key: value for key, value in content.items() if key != SEAL}
    return {**pairs, SEAL: _digest(pairs)}


def is_broken(content: Mapping[str, str]) -> bool:
    """Whether a record is not what was sealed; without a seal, of older versions, nobody knows."""
    stated = content.get(SEAL)
    return stated is not None and stated != sealed(content)[SEAL]


def without_checks(content: Mapping[str, str]) -> dict[str, str]:
    """Return what a record says, without what only protects it."""
    return {key: value for key, value in content.items() if key not in _CHECKS}


def crc_text(crc: int) -> str:
    """Write a CRC-32 as it stands in a record."""
    return f'{crc:08x}'


def sha256_of(files: Mapping[str, bytes]) -> str:
    """Write the SHA-256 of each file as JSON, by name."""
    return json.dumps({name: hashlib.sha256(files[name]).hexdigest() for name in sorted(files)})


def altered_files(text: str | None, files: Mapping[str, bytes]) -> list[str]:
    """Name the files that are not those of which `sha256_of` wrote the text (None: unknown)."""
    if text is None:
        return []
    try:
        stated = json.loads(text)
        actual = json.loads(sha256_of(files))
        names = stated.keys() | actual.keys()
    except (ValueError, RecursionError, AttributeError):
        return sorted(files) or ['(none)']
    return sorted(name for name in names if stated.get(name) != actual.get(name))


def _digest(pairs: Mapping[str, str]) -> str:
    text = json.dumps(sorted(pairs.items()))
    return hashlib.sha256(text.encode()).hexdigest()
