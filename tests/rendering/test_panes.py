"""Lamps through panes: the same light as by chance alone, which is right and noisy."""

from dataclasses import replace

import numpy as np
import pytest
from fakes.scenes import Studio, scene
from oracles.heads import ellipsoid_part, stand_in

from lrsr.identities.head import Head
from lrsr.rendering.live_scene import LiveScene
from lrsr.rendering.scene import Film

IPD_PX = 8.0


@pytest.fixture(scope="module")
def glazed() -> Head:
    """An egg behind a bowl of glass, all of its face."""
    head = stand_in(2, grey=0.5)
    bowl = ellipsoid_part("lenses", "glass", (80, 90, 30), (0, -10, 12), np.ones((4, 4, 3)), 24, 48)
    keep = (bowl.vertices[bowl.faces][..., 2] > 14).all(axis=1)
    return replace(head, parts=(*head.parts, replace(bowl, faces=bowl.faces[keep])))


def seen(studio: Studio, head: Head, samples: int) -> np.ndarray:
    """Return the mean light of what lies behind glass, by colour."""
    image = studio.render(head, ipd_px=IPD_PX, samples_per_pixel=samples).image.numpy()
    survey = studio.survey(head, scene(), Film(IPD_PX))
    middle = survey.mask("lenses") & (survey.normals[..., 2] > 0.8)
    return np.asarray(image[:, middle].mean(axis=1))


@pytest.mark.parametrize("skin", ["reflective", "subsurface"])
def test_lamps_behind_glass_give_what_chance_gives(
    skin: str, glazed: Head, monkeypatch: pytest.MonkeyPatch
) -> None:
    through = seen(Studio(skin, max_depth=5), glazed, 256)
    monkeypatch.setattr(LiveScene, "_is_glazed", lambda scene: False)
    chance = seen(Studio(skin, max_depth=9), glazed, 1024)
    np.testing.assert_allclose(through, chance, rtol=0.05)


def test_glass_takes_and_adds_little_of_a_face_in_soft_light(
    renderer: Studio, glazed: Head
) -> None:
    bare = replace(glazed, parts=glazed.parts[:-1])
    image = renderer.render(bare, ipd_px=IPD_PX, samples_per_pixel=256).image.numpy()
    survey = renderer.survey(glazed, scene(), Film(IPD_PX))
    middle = survey.mask("lenses") & (survey.normals[..., 2] > 0.8)
    ratio = seen(renderer, glazed, 256) / image[:, middle].mean(axis=1)
    # Twice through 92 %, and a mirror image of the lamp on top, over this bowl a quarter more.
    assert (ratio > 0.92**2).all()
    assert (ratio < 1.4).all()
