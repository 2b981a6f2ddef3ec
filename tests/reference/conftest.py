"""The climate of the default settings."""

import pytest
from flights import climate_of


@pytest.fixture(scope="session")
def climate():
    return climate_of({})
