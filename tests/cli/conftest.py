"""Of the two compositions of a command, the one that its words are checked against is shared."""

import pytest
from fakes.configurations import compose_keys_once


@pytest.fixture(autouse=True)
def _keys_once(monkeypatch: pytest.MonkeyPatch) -> None:
    compose_keys_once(monkeypatch)
