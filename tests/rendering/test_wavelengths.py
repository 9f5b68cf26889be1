"""Single wavelengths become bands, without loss and each in its own."""

import numpy as np

from lrsr.spectra import photometric_unit

Seen = dict[str, np.ndarray]


def test_wavelengths_of_a_ray_are_even_over_the_span(traced: Seen) -> None:
    drawn = traced["drawn"]
    assert drawn.shape == (4, 1000)
    steps = np.sort(drawn, axis=0)
    np.testing.assert_allclose(np.diff(steps, axis=0), 350 / 4, atol=1e-3)
    counts, _ = np.histogram(drawn, bins=35, range=(380, 730))
    assert np.abs(counts - 4000 / 35).max() <= 4  # stratified numbers went in
    assert (traced["weight"] == 350).all()


def test_light_is_counted_in_the_band_of_its_wavelength(traced: Seen) -> None:
    bands = traced["split"] / (traced["unit"] * photometric_unit() / (10 * 4))
    # 455 nm with 2 on all rays; one more at 380, 389.99, 390, 555 and 729.99 nm; the rest outside.
    wanted = np.zeros((35, 6))
    wanted[7] = 2
    for band, ray in ((0, 0), (0, 1), (1, 2), (17, 3), (34, 4)):
        wanted[band, ray] += 1
    np.testing.assert_allclose(bands, wanted, rtol=1e-5)
