"""Compilation by numba, with the machine code kept on disk if possible."""

import numba


def compiled(**options):
    """Decorator that compiles a function with numba's `options` and keeps the result on disk.

    Every process compiles anew if neither the package's folder nor the user's cache is writable,
    for example in a container whose user has no home.
    """

    def compile_function(function):
        try:
            return numba.njit(cache=True, **options)(function)
        except RuntimeError as error:
            if "cannot cache" not in str(error):
                raise
            return numba.njit(**options)(function)

    return compile_function
