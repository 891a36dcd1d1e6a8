"""Compares strategies for missing motors on the same hands and scenes: `palpate compare`."""
