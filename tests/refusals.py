"""What refuses bad input does so in one line."""

from contextlib import contextmanager

import pytest


@contextmanager
def refusal(message):
    """A ValueError of one line that matches; gives it as `pytest.raises` does."""
    with pytest.raises(ValueError, match=message) as error:
        yield error
    assert "\n" not in str(error.value)
