"""Measured filters, per energy and per quantum."""

from pathlib import Path

import numpy as np
import pytest

from lrsr.camera.sensitivities import Sensitivities, colorchecker, find_sensitivities
from lrsr.errors import InputError
from lrsr.spectra import band_edges, daylight

EDGES = band_edges(35)
MIDDLE = np.array(EDGES[:-1]) + 5
NM = np.arange(380.0, 731.0, 5.0)
FLAT = np.ones((3, len(NM)))


def test_the_nikon_is_the_one_that_was_measured() -> None:
    nikon = find_sensitivities("nikon_d5100")
    assert nikon.nm[[0, -1]].tolist() == [380, 780]
    # Darrodi et al. 2015, as published: 460 nm and 600 nm.
    assert nikon.curves[:, nikon.nm == 460].ravel() == pytest.approx([0.040228, 0.25424, 1.0])
    assert nikon.curves[:, nikon.nm == 720].max() < 1e-3, "infrared is cut"


def test_daylight_white_gives_the_levels_of_adobes_matrix() -> None:
    to_raw = np.array([[8198, -2239, -724], [-4871, 12389, 2798], [-1043, 2050, 7181]])
    raw = to_raw @ (0.95047, 1.0, 1.08883)  # dcraw's table for the D5100; XYZ of D65
    weights = find_sensitivities("nikon_d5100").weights(EDGES)
    assert weights @ daylight(EDGES) == pytest.approx(raw / raw.max(), abs=1e-3)


def test_curves_as_they_are_keep_their_ratios_and_fill_the_strongest() -> None:
    curves = FLAT * [[0.2], [0.5], [0.3]]
    white = Sensitivities("mine", NM, curves).weights(EDGES) @ daylight(EDGES)
    assert white == pytest.approx([0.4, 1.0, 0.6])


def test_photosites_count_quanta() -> None:
    # Equal energies at 450 and 600 nm: a photon's energy is hc / λ, so electrons go as 450 to 600.
    per_quantum = Sensitivities("detector", NM, FLAT, "quanta").weights(EDGES)
    blue, red = np.searchsorted(MIDDLE, (455, 605))
    assert per_quantum[1, blue] / per_quantum[1, red] == pytest.approx(455 / 605, rel=1e-6)
    per_energy = Sensitivities("same", NM, FLAT * NM / 500, "energy").weights(EDGES)
    np.testing.assert_allclose(per_energy, per_quantum, rtol=1e-9)


def test_filters_in_a_file(tmp_path: Path) -> None:
    file = tmp_path / "mine.csv"
    file.write_text("# nm,red,green,blue\n400,0,0,1\n500,0,1,0\n600,1,0,0\n700,0,0,0\n")
    mine = find_sensitivities(str(file), "quanta")
    assert (mine.name, mine.per, mine.daylight_levels) == ("mine", "quanta", None)
    assert mine.curves.argmax(axis=1).tolist() == [2, 1, 0]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("400,1,1\n700,1,1\n", "wanted four columns: nm, red, green, blue"),
        ("400,a,1,1\n", "is no table of numbers"),
        ("700,1,1,1\n400,1,1,1\n", "wanted rising wavelengths"),
        ("400,1,1,1\n500,1,-1,1\n700,1,1,1\n", "curves >= 0"),
        ("400,1,0,1\n500,1,0,1\n700,1,0,1\n", "answer to visible light"),
    ],
    ids=["columns", "words", "falling", "negative", "blind"],
)
def test_a_file_that_holds_no_filters_is_refused(tmp_path: Path, text: str, says: str) -> None:
    file = tmp_path / "bad.csv"
    file.write_text(text)
    with pytest.raises(InputError, match=says):
        find_sensitivities(str(file))


def test_unknown_filters_and_units_are_refused() -> None:
    with pytest.raises(InputError, match="sensitivities=canon: give one of nikon_d5100, or"):
        find_sensitivities("canon")
    with pytest.raises(InputError, match="per=lumen: choose one of energy, quanta"):
        Sensitivities("mine", NM, FLAT, "lumen")


def test_a_colorchecker_has_its_grey_row_and_its_colours() -> None:
    patches = colorchecker(EDGES)
    assert patches.shape == (24, 35)
    beyond = patches[:, MIDDLE > 450]
    assert beyond[18:].std(axis=1).max() < 0.02, "greys are even"
    assert (np.diff(beyond[18:].mean(axis=1)) < 0).all(), "from white to black"
    assert patches[14, MIDDLE > 620].mean() > 5 * patches[14, MIDDLE < 560].mean(), "red"
