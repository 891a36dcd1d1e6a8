"""The program's random numbers, so that a simulation has the same draws as the program."""

from __future__ import annotations

import struct

import numpy as np
import numpy.typing as npt

Words = npt.NDArray[np.uint64]
_MASK = (1 << 64) - 1


def key_hash(*fields: str) -> int:
    """The program's hash of texts (`engine/trials/key_hash.h`): FNV-1a of each text with the byte
    "t" and its length in front, and the finalizer of MurmurHash3."""
    value = 14695981039346656037
    for text in fields:
        raw = text.encode()
        for byte in b"t" + struct.pack("<Q", len(raw)) + raw:
            value = (value ^ byte) * 1099511628211 & _MASK
    for factor in (0xFF51AFD7ED558CCD, 0xC4CEB9FE1A85EC53):
        value = (value ^ value >> 33) * factor & _MASK
    return value ^ value >> 33


def mt19937_64(seed: int, count: int) -> Words:
    """The first numbers of std::mt19937_64 (Nishimura 2000), which NumPy lacks."""
    size, half = 312, 156
    start = [seed & _MASK]
    for i in range(1, size):
        start.append((6364136223846793005 * (start[-1] ^ start[-1] >> 62) + i) & _MASK)
    state: Words = np.array(start, dtype=np.uint64)
    blocks = []
    for _ in range(-(-count // size)):
        old, state = state, np.empty_like(state)
        state[:half] = old[half:] ^ _twisted(old[:half], old[1:half + 1])
        state[half:-1] = state[:half - 1] ^ _twisted(old[half:-1], old[half + 1:])
        state[-1:] = state[half - 1:half] ^ _twisted(old[-1:], state[:1])
        blocks.append(state)
    x = np.concatenate(blocks or [state])[:count]
    x = x ^ (x >> np.uint64(29) & np.uint64(0x5555555555555555))
    x = x ^ (x << np.uint64(17) & np.uint64(0x71D67FFFEDA60000))
    x = x ^ (x << np.uint64(37) & np.uint64(0xFFF7EEE000000000))
    return x ^ x >> np.uint64(43)


def _twisted(upper: Words, lower: Words) -> Words:
    x = upper & np.uint64(0xFFFFFFFF80000000) | lower & np.uint64(0x7FFFFFFF)
    return x >> np.uint64(1) ^ (x & np.uint64(1)) * np.uint64(0xB5026F5AA96619E9)
