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


class PartReader:
    """Reads a payload piece by piece, from the end of its stamp on; what is wrong is CdrError."""

    def __init__(self, type_name: str, payload: bytes, order: int) -> None:
        self._type_name = type_name
        self._payload = payload
        self._order = order
        self._at = 12

    @property
    def left(self) -> int:
        """Bytes that were not read yet."""
        return len(self._payload) - self._at

    def align(self, alignment: int) -> None:
        """Pass over padding; alignment counts from byte 4."""
        self._at = 4 + up(self._at - 4, alignment)

    def text(self) -> str:
        """Read a text."""
        return text_of(self.take(self.u32()), self._type_name)

    def u32(self) -> int:
        """Read a number without sign, aligned."""
        self.align(4)
        return U32[self._order].unpack(self.take(4))[0]

    def byte(self) -> int:
        """Read one byte."""
        return self.take(1)[0]

    def take(self, size: int) -> bytes:
        """Read as many bytes as they are."""
        end = self._at + size
        self.need(end <= len(self._payload), f'{len(self._payload)} bytes, expected {end}')
        content = bytes(self._payload[self._at : end])
        self._at = end
        return content

    def need_end(self) -> None:
        """Refuse bytes after the last field."""
        self.need(self.left == 0, f'{self.left} bytes more')

    def need(self, condition: bool, problem: str) -> None:
        """Refuse the message unless the condition holds."""
        require(condition, self._type_name, problem)


class PartWriter:
    """Writes a payload piece by piece, little endian; each call returns where its value begins."""

    def __init__(self) -> None:
        self.content = bytearray(b'\0\1\0\0')

    def align(self, alignment: int) -> int:
        """Fill up with zeros; alignment counts from byte 4."""
        self.content += bytes(-(len(self.content) - 4) % alignment)
        return len(self.content)

    def text(self, text: str) -> int:
        """Write a text."""
        at = self.align(4)
        self.content += string(text)
        return at

    def words(self, *values: int) -> int:
        """Write numbers of four bytes, with or without sign."""
        at = self.align(4)
        self.content += b''.join(U32[1].pack(value & 0xFFFFFFFF) for value in values)
        return at

    def floats(self, *values: float) -> int:
        """Write numbers in single precision."""
        at = self.align(4)
        self.content += Struct(f'<{len(values)}f').pack(*values)
        return at

    def doubles(self, *values: float) -> int:
        """Write numbers in double precision."""
        at = self.align(8)
        self.content += Struct(f'<{len(values)}d').pack(*values)
        return at

    def raw(self, content: bytes) -> int:
        """Write bytes as they are."""
        at = len(self.content)
        self.content += content
        return at
