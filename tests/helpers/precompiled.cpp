// Intentionally empty: the target that precompiles the tests' headers needs a source.
