# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Numbers and texts in CDR bytes, and the error for bytes that are no message."""

from __future__ import annotations

from struct import Struct

U32 = {0: Struct('>I'), 1: Struct('<I')}  # by byte order: big, little


class CdrError(ValueError):
    """Bytes that are not a message of the named type."""


def up(size: int, alignment: int) -> int:
    """Round a size up to a multiple of the alignment."""
    return -(-size // alignment) * alignment


def string(text: str) -> bytes:
    """Return the bytes of a text: its length with the NUL at its end, and itself."""
    content = text.encode()
    if b'\0' in content:
        raise CdrError(f'text {text!r} contains NUL; a CDR string cannot hold it')
    return U32[1].pack(len(content) + 1) + content + b'\0'


def text_of(content: bytes, type_name: str) -> str:
    """Text of a CDR string; some writers give the empty string length 0, without its NUL."""
    if not content:
        return ''
    require(
        content.find(b'\0') == len(content) - 1, type_name, 'a text has no NUL at its end alone'
    )
    try:
        return bytes(content[:-1]).decode()
    except UnicodeDecodeError as error:
        raise CdrError(f'{type_name}: a text is not UTF-8: {error}') from error


def require(condition: bool, type_name: str, problem: str) -> None:
    """Refuse a message unless the condition holds."""
    if not condition:
        raise CdrError(f'{type_name}: {problem}')
