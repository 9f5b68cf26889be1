"""The part's public names are there, and cost nothing until they are used."""

import subprocess
import sys

import pytest

import lrsr.data


@pytest.mark.parametrize("name", lrsr.data.__all__)
def test_every_public_name_can_be_had(name: str) -> None:
    assert getattr(lrsr.data, name).__name__ == name


def test_no_other_name_can() -> None:
    with pytest.raises(AttributeError, match="no attribute 'Probes'"):
        lrsr.data.Probes  # noqa: B018 - asking is the test


def test_importing_the_part_loads_nothing_heavy() -> None:
    script = "import sys, lrsr.data; print(*{'torch', 'kornia', 'lightning'} & set(sys.modules))"
    loaded = subprocess.run([sys.executable, "-c", script], capture_output=True, check=True)
    assert loaded.stdout == b"\n"
