"""Random streams and rounded numbers that do not depend on the order of work or the processor.

Every purpose has a random generator of its own, named by keys, never by its position in a batch.
Sums of products, logarithms and powers differ in their last bits between x86-64 processors.
Numbers that are written to files are therefore rounded, and later steps get equal input.
"""

import hashlib

import numpy as np


def seed_entropy(seed, *keys):
    """Entropy of 128 bits, as an int, which depends only on `seed`, the keys and their order.

    Keys are compared as text, so that ``1`` and ``"1"`` name the same stream.
    """
    text = "\x1f".join(str(part) for part in (seed, *keys))
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:16], "little")


def random_stream(seed, *keys):
    """NumPy random generator for one purpose of a run, which keys name, most general first.

    An example is ``random_stream(seed, "render_phy", scene)``. The generator is PCG64, seeded by
    `seed_entropy`. Streams are independent of each other. They do not depend on the order of work,
    or on its division among processes.
    """
    return np.random.Generator(np.random.PCG64(seed_entropy(seed, *keys)))


def generator(rng):
    """The generator `rng` itself, or a new one if `rng` is a seed; else ValueError."""
    try:
        return np.random.default_rng(rng)
    except (TypeError, ValueError):
        msg = f"rng must be a numpy.random.Generator or a seed from 0, got {rng!r}"
        raise ValueError(msg) from None


def rounded(values, n_bits):
    """Values rounded to `n_bits` binary digits, float64; NaN and infinities stay.

    The relative error is at most 2^-`n_bits`: 1e-6 for 20, 1.5e-5 (7e-5 dB of power) for 16.
    """
    mantissa, exponent = np.frexp(np.asarray(values, dtype=float))
    return np.ldexp(np.rint(np.ldexp(mantissa, n_bits)), exponent - n_bits)
