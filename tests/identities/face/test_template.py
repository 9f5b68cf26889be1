import numpy as np
from scipy.spatial import cKDTree

from lrsr.identities.face.template import template
from lrsr.identities.shape.basis import load_basis


def test_the_template_is_as_large_as_an_adult() -> None:
    skin, eyes = template().skin, template().eyes
    # Farkas et al. 2005: the face is about 130 to 140 mm wide; Dodgson 2004: pupils 63 mm apart.
    face = skin[np.abs(skin[:, 1] + 19) < 5]
    face = face[np.abs(face[:, 2] + 42) < 5]
    assert 125 < np.ptp(face[:, 0]) < 150
    assert 58 < np.linalg.norm(np.diff(eyes.pupils, axis=0)) < 68


def test_the_template_is_the_same_on_both_sides() -> None:
    skin = template().skin
    away, _ = cKDTree(skin).query(skin * (-1.0, 1.0, 1.0))
    assert np.percentile(away, 99) < 0.5  # the lips alone are not quite even
    np.testing.assert_allclose(skin.mean(axis=0)[0], 0.0, atol=0.5)


def test_the_template_lies_between_its_eyes() -> None:
    eyes = template().eyes
    np.testing.assert_allclose(eyes.centres.mean(axis=0)[:2], 0.0, atol=1e-9)


def test_the_template_has_a_vertex_for_every_one_of_the_surface() -> None:
    assert template().skin.shape == (load_basis().surface.matrix.shape[0], 3)
