"""The terms of a full factorial model."""

from collections.abc import Sequence
from itertools import combinations

# The factors of an effect, in the order of the model: ("haptic",), ("haptic", "rotation").
Term = tuple[str, ...]


def all_terms(factors: Sequence[str]) -> list[Term]:
    """Main effects, then interactions of two factors, and so on; of one size, the terms without
    the last factor come first."""
    place = {name: i for i, name in enumerate(factors)}
    terms = [t for size in range(1, len(factors) + 1) for t in combinations(factors, size)]
    return sorted(terms, key=lambda term: (len(term), [place[name] for name in reversed(term)]))


def effect_name(term: Term) -> str:
    """As the paper writes it, the last factor first: "Rotation x Haptic"."""
    return " x ".join(reversed(term))
