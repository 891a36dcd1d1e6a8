"""What each strategy does, for readers: as in docs/reference/strategies.md."""

from __future__ import annotations

_MEANINGS = {
    "none": "no force (a reference)",
    "mask": "the part of the force along the motors",
    "full": "the whole force, as if every axis had a motor (a reference)",
    "a4": "mask, and A4 turns the scene in contact",
    "a4-anticipate": "a4, and the scene turns before the touch",
    "a4-passive": "a4, but the turns of a contact add at most {} mJ to the spring of the motors",
    "anisotropic": "the proxy rests where the distance to the device is least; the part across the "
                   "motors counts E = {} times",
    "cd": "mask, and while the hand presses, the scene follows a part of its motion",
}


def meaning(strategy: str) -> str:
    """One line; empty for a name that is not known."""
    name, _, parameter = strategy.partition(":")
    return _MEANINGS.get(name, "").format(parameter)
