"""Functions compiled by numba, whose machine code is kept on disk where that can be."""

import numba


def compiled(**options):
    """Decorator that compiles a function with numba's `options` and keeps the result on disk.

    Where neither the package's folder nor a cache of the user can be written to, as in a container
    run by a user without a home, every process compiles anew.
    """

    def decorate(function):
        try:
            return numba.njit(cache=True, **options)(function)
        except RuntimeError as error:
            if "cannot cache" not in str(error):
                raise
            return numba.njit(**options)(function)

    return decorate
