"""Here figures are drawn: they are what these tests are about."""

import pytest


@pytest.fixture(scope="module")
def no_figures() -> None:
    """Take nothing away."""
