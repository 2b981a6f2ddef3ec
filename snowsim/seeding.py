"""Numbers that do not depend on where and in which order they are computed.

One independent random generator per purpose is named by keys, never by position in a batch. Sums of
products, logarithms and powers end in other last bits on other kinds of x86-64 processor; what
follows from a number that a file keeps must not, so such numbers are rounded.
"""

import hashlib

import numpy as np


def seed_entropy(seed, *keys):
    """128 bits, as an int, that depend on `seed`, every key and their order, and on nothing else.

    Keys count by their text, so that ``1`` and ``"1"`` name the same stream.
    """
    text = "\x1f".join(str(part) for part in (seed, *keys))
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:16], "little")


def random_stream(seed, *keys):
    """numpy.random.Generator for one purpose of a run, named by keys, most general first.

    An example is ``random_stream(seed, "render_phy", scene)``. The generator is PCG64, seeded by
    `seed_entropy`. Streams are independent of each other, and of the order and division of work.
    """
    return np.random.Generator(np.random.PCG64(seed_entropy(seed, *keys)))


def generator(rng):
    """The generator `rng` or, if that is a seed, its generator; ValueError for anything else."""
    try:
        return np.random.default_rng(rng)
    except (TypeError, ValueError):
        msg = f"rng must be a numpy.random.Generator or a seed from 0, got {rng!r}"
        raise ValueError(msg) from None


def rounded(values, n_bits):
    """Values with so many binary digits, float64 of the same shape; NaN and infinities stay.

    The relative error is at most 2^-`n_bits`: 1e-6 for 20, 1.5e-5 (7e-5 dB of power) for 16.
    """
    mantissa, exponent = np.frexp(np.asarray(values, dtype=float))
    return np.ldexp(np.rint(np.ldexp(mantissa, n_bits)), exponent - n_bits)
