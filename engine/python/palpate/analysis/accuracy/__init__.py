"""The page and the figures of `palpate accuracy`."""
