"""Pictures come from the cache, or are made once; killed or interrupted, nothing is lost."""

import logging
import random
import threading
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import pytest
import torch
from fakes.elsewhere import finish, run_script
from fakes.maker import FakeMaker
from fakes.scenes import recipe
from fakes.twins import TwinMaker, traits

from lrsr.camera import Camera
from lrsr.camera.exposure import KEY
from lrsr.camera.optics import bin_pixels
from lrsr.camera.sensor import Sensor
from lrsr.camera.spectral import SpectralColour
from lrsr.errors import InputError
from lrsr.identities.head import Head
from lrsr.images import linear_to_srgb
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.recipe import Recipe
from lrsr.pictures.render import (
    _photograph,
    filmed,
    load_radiances,
    render_missing,
    take_pictures,
)
from lrsr.rendering.radiance import Radiance


def recipes(people: int = 3, scales: Sequence[int] = (1, 2)) -> list[Recipe]:
    return [recipe(index, scale=scale, ipd_px=4) for scale in scales for index in range(people)]


def entries(cache: RenderCache) -> list[Path]:
    return sorted(cache.folder.rglob("*.safetensors"))


def test_what_is_missing_is_rendered_once(cache: RenderCache, maker: FakeMaker) -> None:
    wanted = recipes()
    assert render_missing([*wanted, *wanted], cache, progress=False, maker=maker) == 6
    assert sorted(maker.renders, key=wanted.index) == wanted
    assert render_missing(wanted, cache, progress=False, maker=maker) == 0
    assert len(maker.renders) == len(entries(cache)) == 6


def test_a_head_is_built_once_however_the_recipes_are_ordered(
    cache: RenderCache, maker: FakeMaker
) -> None:
    wanted = recipes(5, scales=(1, 2, 4))
    random.Random(0).shuffle(wanted)
    render_missing(wanted, cache, progress=False, maker=maker)
    assert sorted(maker.heads) == [f"test-{i:05d}" for i in range(5)]
    order = [made.person.index for made in maker.renders]
    assert sum(a != b for a, b in pairwise(order)) == 4


def test_no_head_is_built_for_what_is_there(cache: RenderCache, maker: FakeMaker) -> None:
    render_missing(recipes(2), cache, progress=False, maker=maker)
    render_missing(recipes(3), cache, progress=False, maker=maker)
    assert maker.heads == ["test-00000", "test-00001", "test-00002"]


def test_the_next_head_is_built_while_this_one_is_rendered(cache: RenderCache) -> None:
    built = threading.Event()

    class Watched(FakeMaker):
        def head(self, recipe: Recipe) -> Head:
            if recipe.person.index == 1:
                built.set()
            return super().head(recipe)

        def render(self, head: Head, recipe: Recipe) -> Radiance:
            assert built.wait(timeout=30), "head 1 was not begun during the rendering of head 0"
            assert threading.current_thread() is threading.main_thread()
            return super().render(head, recipe)

    assert render_missing(recipes(2, (1,)), cache, progress=False, maker=Watched()) == 2


def test_new_versions_are_rendered_anew(cache: RenderCache, maker: FakeMaker) -> None:
    render_missing(recipes(1), cache, progress=False, maker=maker)
    maker.versions = {**maker.versions, "renderer": "2"}
    assert render_missing(recipes(1), cache, progress=False, maker=maker) == 2


def test_nothing_to_do_is_done_at_once(cache: RenderCache, maker: FakeMaker) -> None:
    assert render_missing([], cache, maker=maker) == 0


def test_progress_goes_to_stderr_and_can_be_silent(
    cache: RenderCache, maker: FakeMaker, capfd: pytest.CaptureFixture[str]
) -> None:
    render_missing(recipes(2), cache, maker=maker)
    out, err = capfd.readouterr()
    assert out == ""
    assert "rendering" in err
    assert "4/4" in err
    render_missing(recipes(3), cache, progress=False, maker=maker)
    assert capfd.readouterr() == ("", "")


def test_a_damaged_entry_is_reported_once_and_made_again(
    cache: RenderCache, maker: FakeMaker, caplog: pytest.LogCaptureFixture
) -> None:
    render_missing(recipes(), cache, progress=False, maker=maker)
    before = {path: path.read_bytes() for path in entries(cache)}
    damaged = entries(cache)[2]
    damaged.write_bytes(damaged.read_bytes()[:-4] + b"oops")
    with caplog.at_level(logging.WARNING):
        assert render_missing(recipes(), cache, progress=False, maker=maker) == 1
        load_radiances(recipes(), cache, progress=False, maker=maker)
    assert [message.split(" (")[0] for message in caplog.messages] == [
        f"damaged cache entry {damaged}"
    ]
    assert {path: path.read_bytes() for path in entries(cache)} == before


def test_a_failure_while_rendering_keeps_what_was_done(cache: RenderCache) -> None:
    class Failing(FakeMaker):
        def render(self, head: Head, recipe: Recipe) -> Radiance:
            if recipe.person.index == 2:
                raise KeyboardInterrupt
            return super().render(head, recipe)

    with pytest.raises(KeyboardInterrupt):
        render_missing(recipes(4, (1,)), cache, progress=False, maker=Failing())
    again = FakeMaker()
    assert render_missing(recipes(4, (1,)), cache, progress=False, maker=again) == 2
    assert [made.person.index for made in again.renders] == [2, 3]


def test_a_failure_while_building_a_head_is_raised_here(cache: RenderCache) -> None:
    class Failing(FakeMaker):
        def head(self, recipe: Recipe) -> Head:
            if recipe.person.index == 1:
                raise ZeroDivisionError("no such person")
            return super().head(recipe)

    with pytest.raises(ZeroDivisionError, match="no such person"):
        render_missing(recipes(3, (1,)), cache, progress=False, maker=Failing())
    assert len(entries(cache)) == 1


def test_a_cache_that_cannot_be_written_is_one_line(tmp_path: Path, maker: FakeMaker) -> None:
    cache = RenderCache(tmp_path / "file" / "cache")
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match=r"cannot (read|write) "):
        render_missing(recipes(1), cache, progress=False, maker=maker)


def test_a_cache_that_forgets_is_noticed(
    cache: RenderCache, maker: FakeMaker, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(RenderCache, "put", lambda *_: None)
    with pytest.raises(InputError, match="loses what is written to it"):
        take_pictures(recipes(1), cache, Camera(), progress=False, maker=maker)


KILLED = """
import os, signal, sys, time
from pathlib import Path
from fakes.elsewhere import finish, run_script
from fakes.maker import FakeMaker
from fakes.scenes import recipe
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.render import render_missing

recipes = [recipe(i, scale=s, ipd_px=16) for i in range(20) for s in (1, 4)]
for number, seconds in enumerate(sys.argv[2:], 1):
    child = os.fork()
    if child == 0:
        render_missing(recipes, RenderCache(Path(sys.argv[1])), maker=FakeMaker(0.03))
        os._exit(0)
    time.sleep(float(seconds))
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    entries = [*Path(sys.argv[1]).rglob("*.safetensors")]
    print(*sorted(f"{path.name}@{path.stat().st_ino}" for path in entries), flush=True)
    if number >= 6 and entries:
        break
"""


def test_killed_at_random_moments_it_goes_on_with_nothing_lost_doubled_or_half_written(
    tmp_path: Path, maker: FakeMaker
) -> None:
    """kill -9, six times; every finished entry stays, and the end is that of a quiet run.

    On a machine so busy that nothing was finished by then, more times and later.
    """
    folder, quiet = tmp_path / "killed", tmp_path / "quiet"
    moments = [f"{(1 + i // 6) * random.Random(i).uniform(0.03, 0.2):.3f}" for i in range(60)]
    killed = finish(tmp_path / "told", run_script, KILLED, str(folder), *moments)
    assert killed.status == 0, killed.err
    after_each = [set(line.split()) for line in killed.out.splitlines()]
    assert len(after_each) >= 6
    for earlier, later in pairwise(after_each):
        assert earlier <= later, "a finished entry was lost or written again"
    assert 0 < len(after_each[-1]) < 40

    shard = next(folder.glob("??"))
    (shard / ".left-by-one-more-killed-writer.part").touch()
    wanted = [recipe(i, scale=s, ipd_px=16) for i in range(20) for s in (1, 4)]
    for place, missing in ((folder, 40 - len(after_each[-1])), (quiet, 40)):
        assert render_missing(wanted, RenderCache(place), progress=False, maker=maker) == missing
    files = {
        place: {path.name: path.read_bytes() for path in place.glob("*/*")}
        for place in (folder, quiet)
    }
    assert len(files[quiet]) == 40
    assert files[folder] == files[quiet]


def test_a_picture_carries_all_that_is_known(cache: RenderCache) -> None:
    wanted = recipe(9, "train", pose="up", lighting="side", scale=2, seed=5)
    twins = TwinMaker()
    (picture,) = take_pictures([wanted], cache, Camera("heavy"), progress=False, maker=twins)
    assert (picture.identity_id, picture.scale) == ("train-00009", 2)
    assert picture.source == "rendered: up, side"
    assert picture.traits == traits(wanted.person)
    assert picture.image.shape == (3, 64, 64)


def test_landmarks_are_those_of_the_film(cache: RenderCache, maker: FakeMaker) -> None:
    (picture,) = take_pictures([recipe(scale=2)], cache, Camera(), progress=False, maker=maker)
    assert torch.equal(picture.landmarks_px, torch.arange(10.0).reshape(5, 2) * 2)


def test_the_picture_is_what_the_camera_makes_of_the_light(
    cache: RenderCache, maker: FakeMaker
) -> None:
    (light,) = load_radiances([recipe()], cache, progress=False, maker=maker)
    (probe,) = take_pictures([recipe()], cache, Camera(), progress=False, maker=maker)
    wanted = (linear_to_srgb(light.image * KEY / light.metered) * 255).round() / 255
    assert torch.allclose(probe.image, wanted)


def test_probes_come_in_the_order_of_their_recipes_whatever_their_sizes(
    cache: RenderCache, maker: FakeMaker
) -> None:
    wanted = [
        recipe(i % 7, ipd_px=4 + i % 3, scale=(1, 2)[i % 2], pose=("up", "left")[i % 2])
        for i in range(80)
    ]
    probes = take_pictures(wanted, cache, Camera("small"), progress=False, maker=maker)
    for one, probe in zip(wanted, probes, strict=True):
        assert (probe.identity_id, probe.scale) == (one.person.id, one.film.scale)
        assert probe.source == f"rendered: {one.scene.pose.name}, frontal"
        assert probe.image.shape[1] == 4 * one.film.ipd_px * one.film.scale
        alone = take_pictures([one], cache, Camera("small"), progress=False, maker=maker)[0]
        assert torch.equal(probe.image, alone.image)


def test_another_camera_renders_nothing_anew(cache: RenderCache, maker: FakeMaker) -> None:
    for camera in (Camera(), Camera("heavy"), Camera(exposure_ev=1.0)):
        take_pictures(recipes(), cache, camera, progress=False, maker=maker)
    assert len(maker.renders) == 6


def test_a_picture_taken_by_the_differentiable_camera_has_no_gradient(
    cache: RenderCache, maker: FakeMaker
) -> None:
    wanted = recipes(1, (1,))
    lights = load_radiances(wanted, cache, progress=False, maker=maker)
    lights[0].image.requires_grad_()
    (probe,) = _photograph(wanted, lights, Camera("heavy", codec="differentiable"))
    assert not probe.image.requires_grad


def test_no_probes_from_no_recipes(cache: RenderCache, maker: FakeMaker) -> None:
    assert take_pictures([], cache, Camera(), maker=maker) == []


def test_a_head_is_built_once_for_each_expression(cache: RenderCache, maker: FakeMaker) -> None:
    wanted = [
        recipe(ipd_px=ipd_px, expression=expression)
        for ipd_px in (4, 5)
        for expression in ("neutral", "smile")
    ]
    assert render_missing(wanted, cache, progress=False, maker=maker) == 4
    assert maker.heads == ["test-00000", "test-00000"]


NOISY = Camera(supersampling=2, sensor=Sensor(200.0), name="noisy")


def test_the_film_of_a_camera_with_a_lens_is_finer_and_its_picture_is_not(
    cache: RenderCache, maker: FakeMaker
) -> None:
    (one,) = recipes(1, (1,))
    camera = Camera(supersampling=4)
    (probe,) = take_pictures([one], cache, camera, progress=False, maker=maker)
    assert [made.film.scale for made in maker.renders] == [4]
    film = maker.render(maker.head(one), filmed(one, camera))
    picture = Camera()(bin_pixels(film.image[None], 4), torch.tensor([film.metered]))
    assert torch.equal(probe.image, picture[0])
    assert probe.scale == 1
    wanted = (film.landmarks_px + 0.5) / 4 - 0.5
    assert torch.allclose(probe.landmarks_px, wanted, atol=1e-4)


def test_only_the_fineness_of_the_film_changes_what_is_rendered() -> None:
    (one,) = recipes(1, (1,))
    assert filmed(one, Camera("heavy", 1.0, name="other")) == one
    assert filmed(one, NOISY) == filmed(one, Camera(supersampling=2))
    assert replace(filmed(one, NOISY), film=one.film) == one


def test_noise_follows_from_the_picture_and_not_from_its_company(
    cache: RenderCache, maker: FakeMaker
) -> None:
    wanted = [one.seeded(0, "probe") for one in recipes(4, (1,))]
    together = take_pictures(wanted, cache, NOISY, progress=False, maker=maker)
    backwards = take_pictures(wanted[::-1], cache, NOISY, progress=False, maker=maker)[::-1]
    for a, b in zip(together, backwards, strict=True):
        assert torch.equal(a.image, b.image)
    noise = [
        probe.image
        - Camera(supersampling=2)(
            maker.render(maker.head(one), filmed(one, NOISY)).image[None], torch.tensor([2.0])
        )[0]
        for probe, one in zip(together[:2], wanted[:2], strict=True)
    ]
    assert not torch.equal(*noise)


def test_a_film_that_is_not_fine_enough_is_refused(cache: RenderCache, maker: FakeMaker) -> None:
    wanted = recipes(1, (1,))
    lights = load_radiances(wanted, cache, progress=False, maker=maker)
    with pytest.raises(InputError, match="a film of scale 1 in camera 'noisy': wanted 2 times"):
        _photograph(wanted, lights, NOISY)
    with pytest.raises(InputError, match="scale=8: wanted one of"):
        filmed(recipes(1, (4,))[0], NOISY)


MEASURED = Camera(supersampling=2, colour=SpectralColour("nikon_d5100"), name="nikon")


def test_a_camera_with_measured_filters_gets_bands_and_others_take_theirs(
    cache: RenderCache, maker: FakeMaker
) -> None:
    wanted = recipes(2, (1,))
    take_pictures(wanted, cache, MEASURED, progress=False, maker=maker)
    assert [(made.film.scale, made.film.bands) for made in maker.renders] == [(2, 35)] * 2
    plain = take_pictures(wanted, cache, Camera(supersampling=2), progress=False, maker=maker)
    assert [made.film.bands for made in maker.renders] == [35, 35, 0, 0]
    same = take_pictures(wanted, cache, Camera(supersampling=2, bands=35), maker=maker)
    assert len(maker.renders) == 4, "one rendering serves both"
    assert not torch.equal(same[0].image, plain[0].image)  # a fake maker's bands are no colours
    assert filmed(filmed(wanted[0], MEASURED), Camera()).film.bands == 35


def test_films_of_bands_and_of_colours_are_photographed_side_by_side(
    cache: RenderCache, maker: FakeMaker
) -> None:
    (one,) = recipes(1, (1,))
    films = [replace(one, film=replace(one.film, bands=bands)) for bands in (0, 7, 35)]
    lights = load_radiances(films, cache, progress=False, maker=maker)
    probes = _photograph(films, lights, Camera())
    assert len({probe.image.numpy().tobytes() for probe in probes}) == 3
    alone = _photograph(films[1:2], lights[1:2], Camera())
    assert torch.equal(alone[0].image, probes[1].image)


def test_a_film_of_three_colours_is_refused_by_measured_filters(
    cache: RenderCache, maker: FakeMaker
) -> None:
    wanted = recipes(1, (2,))
    lights = load_radiances(wanted, cache, progress=False, maker=maker)
    with pytest.raises(InputError, match=r"need spectral bands.*LRSR_VARIANT"):
        _photograph(wanted, lights, MEASURED)
