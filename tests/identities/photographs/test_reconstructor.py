import hashlib
import shutil
from pathlib import Path

import numpy as np
import pytest
from skimage.data import astronaut

from lrsr.errors import InputError
from lrsr.identities.face.expression import NEUTRAL
from lrsr.identities.photographs.choices import PHOTOGRAPHS_VERSION
from lrsr.identities.photographs.outlines import EYES, FACE, LIP_GAP
from lrsr.identities.photographs.person import Network, Photographed
from lrsr.identities.photographs.reconstructor import Reconstructor, shared_reconstructor
from lrsr.identities.photographs.space import ASSET_NAME
from lrsr.paths import asset

FIVE_PX = ((205.0, 101.0), (247.0, 103.0), (224.0, 129.0), (202.0, 138.0), (244.0, 141.0))
PARTS = (".onnx", ".toml", ".npz")


@pytest.fixture
def foreign(tmp_path: Path) -> Path:
    """The network that ships, as if it were somebody else's."""
    shipped = asset("landmarkers/face_landmark.onnx")
    for part in PARTS:
        shutil.copy(shipped.with_suffix(part), tmp_path / f"theirs{part}")
    return tmp_path / "theirs.onnx"


def test_from_the_fit_on_all_networks_are_alike(foreign: Path) -> None:
    srgb = np.asarray(astronaut() / 255, np.float32)
    ours, theirs = shared_reconstructor()(srgb, FIVE_PX), Reconstructor(foreign)(srgb, FIVE_PX)
    np.testing.assert_array_equal(theirs.fit.rest, ours.fit.rest)
    assert theirs.score == ours.score
    named = [*FACE, *LIP_GAP, *(corner for pair in EYES for corner in pair)]
    apart = np.linalg.norm(theirs.points_px[named] - ours.points_px[named], axis=1)
    assert 0 < np.median(apart) < 3  # of 42 between the pupils: where the fitted face has them


def test_another_calibration_or_space_is_another_version() -> None:
    """Heads in caches go by the version: raise it whenever you change one of these checksums."""
    space = hashlib.sha256(asset(ASSET_NAME).read_bytes()).hexdigest()
    ships = shared_reconstructor().digest[:16], space[:16]
    assert (PHOTOGRAPHS_VERSION, *ships) == ("4", "15dfa37e4c24dbd3", "ebca943db131d1d0")


def test_the_checksum_is_that_of_model_contract_and_calibration(foreign: Path) -> None:
    before = Reconstructor(foreign).digest
    assert before == shared_reconstructor().digest
    contract = foreign.with_suffix(".toml")
    contract.write_text(contract.read_text().replace("side = 1.5", "side = 1.6"))
    assert Reconstructor(foreign).digest != before


def test_somebody_found_by_a_network_that_was_changed_is_refused(
    foreign: Path, tmp_path: Path
) -> None:
    picture = tmp_path / "a.png"
    picture.write_bytes(b"no picture yet")
    network = Network(str(foreign), "ab" * 32)
    sha256 = hashlib.sha256(picture.read_bytes()).hexdigest()
    person = Photographed(str(picture), sha256, FIVE_PX, reconstructor=network)
    with pytest.raises(InputError, match=r"theirs.onnx was changed: run lrsr reconstruct again"):
        person.head(NEUTRAL, 64)


@pytest.mark.parametrize("part", PARTS)
def test_a_network_of_which_a_file_is_missing_is_refused(foreign: Path, part: str) -> None:
    foreign.with_suffix(part).unlink()
    with pytest.raises(InputError, match=rf"theirs\{part} is missing"):
        Reconstructor(foreign)
