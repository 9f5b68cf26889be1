from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from fakes.maker import FakeMaker
from fakes.scenes import scene

from lrsr.camera import Camera
from lrsr.errors import InputError
from lrsr.identities.roster import IdentityRange
from lrsr.pictures.burst import Burst
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.folder import read_manifest, write_manifest
from lrsr.pictures.image_files import write_png
from lrsr.pictures.picture import stack
from lrsr.pictures.render import CHUNK, take_pictures
from lrsr.pictures.sitting import Sitting
from lrsr.pictures.source import (
    Bursts,
    Photographs,
    Rendered,
    bursts_of,
    chunks,
    read_photographs,
    references_of,
    render_sources,
)
from lrsr.pictures.to_folder import RenderSettings, render_to_folder
from lrsr.rendering.scene import Film, Quality

SITTING = Sitting(IdentityRange(count=3), scene("left"), Film(), Quality())
BURSTS = replace(SITTING, burst=Burst("test", 0.1, yaw_deg=2))


@pytest.fixture
def folder(tmp_path: Path, cache: RenderCache, maker: FakeMaker) -> Path:
    """Of three probes with references, and of their enrolled pictures."""
    out = tmp_path / "out"
    for sitting, scales in (
        (SITTING, (1, 2, 4)),
        (replace(SITTING, scene=scene(), film=Film(16.0), kind="gallery"), (1,)),
    ):
        settings = RenderSettings(out, sitting, Camera(), scales=scales)
        render_to_folder(settings, cache, progress=False, maker=maker)
    return out


def photograph(path: Path, height: int = 8, width: int = 6) -> torch.Tensor:
    """Write a picture of random tones that 8 bits hold."""
    levels = np.random.default_rng(len(path.name)).integers(0, 256, (3, height, width))
    image = torch.from_numpy(levels.astype(np.float32) / 255)
    path.parent.mkdir(parents=True, exist_ok=True)
    write_png(path, image)
    return image


def test_a_manifest_tells_probes_from_gallery_and_from_references(folder: Path) -> None:
    probes, gallery = read_photographs(folder, "probe"), read_photographs(folder, "gallery")
    people = ["test-00000", "test-00001", "test-00002"]
    assert list(probes.identity_ids) == list(gallery.identity_ids) == people
    assert {(entry.kind, entry.scale, entry.pose) for entry in probes.entries} == {
        ("probe", 1, "left")
    }
    assert {(entry.kind, entry.ipd_px) for entry in gallery.entries} == {("gallery", 16.0)}


def test_what_is_read_is_what_was_taken(folder: Path, cache: RenderCache, maker: FakeMaker) -> None:
    taken = take_pictures(SITTING.recipes(), cache, Camera(), maker=maker)
    for read, one in zip(read_photographs(folder, "probe").load(0, 3), taken, strict=True):
        assert torch.equal(read.image, one.image)
        assert torch.equal(read.landmarks_px, one.landmarks_px)
        assert (read.identity_id, read.scale) == (one.identity_id, one.scale)


def test_a_folder_without_a_manifest_is_probes_and_gallery(tmp_path: Path) -> None:
    image = photograph(tmp_path / "anna" / "1.png")
    photograph(tmp_path / "anna" / "22.png")
    photograph(tmp_path / "bert.png")
    for kind in ("probe", "gallery"):
        source = read_photographs(tmp_path, kind)
        assert list(source.identity_ids) == ["anna", "anna", "bert"]
        (first,) = source.load(0, 1)
        assert torch.equal(first.image, image)
        assert first.source == str(tmp_path / "anna" / "1.png")


def test_a_folder_of_the_other_kind_is_refused(folder: Path) -> None:
    write_manifest(folder, [row for row in read_manifest(folder) if row.kind == "gallery"])
    with pytest.raises(InputError, match="holds no pictures of the kind probe: give another"):
        read_photographs(folder, "probe")


def test_no_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="absent is no folder"):
        read_photographs(tmp_path / "absent", "probe")


@pytest.mark.parametrize("scale", [2, 4])
def test_each_probes_reference_is_found_beside_it(folder: Path, scale: int) -> None:
    rows = read_manifest(folder)
    write_manifest(folder, rows[::-1])
    probes = read_photographs(folder, "probe")
    found = references_of(probes, scale)
    assert found is not None
    assert list(found.identity_ids) == list(probes.identity_ids)
    for probe, reference in zip(probes.load(0, 3), found.load(0, 3), strict=True):
        assert reference.scale == scale
        assert reference.image.shape[-1] == scale * probe.image.shape[-1]


@pytest.mark.parametrize(
    "other", [{"yaw_deg": 1.0}, {"standpoint": "scface_far"}, {"skin": "tone"}], ids=str
)
def test_a_reference_of_another_scene_is_none(folder: Path, other: dict[str, Any]) -> None:
    rows = read_manifest(folder)
    write_manifest(folder, [replace(r, **other) if r.scale == 2 else r for r in rows])
    probes = read_photographs(folder, "probe")
    assert references_of(probes, 2) is None
    assert references_of(probes, 4) is not None


def test_one_missing_reference_is_as_good_as_none(folder: Path) -> None:
    rows = read_manifest(folder)
    lost = next(row for row in rows if row.scale == 4)
    write_manifest(folder, [row for row in rows if row != lost])
    assert references_of(read_photographs(folder, "probe"), 4) is None


def test_photographs_have_no_references(tmp_path: Path) -> None:
    photograph(tmp_path / "anna.png")
    assert references_of(read_photographs(tmp_path, "probe"), 2) is None


def test_chunks_are_all_pictures_once_in_order(tmp_path: Path) -> None:
    for number in range(CHUNK + 2):
        photograph(tmp_path / f"{number:03d}.png", 2, 2)
    source = read_photographs(tmp_path, "probe")
    found = list(chunks(source))
    assert [(place.start, place.stop) for place, _ in found] == [(0, CHUNK), (CHUNK, CHUNK + 2)]
    assert [one.identity_id for _, some in found for one in some] == list(source.identity_ids)
    assert list(chunks(Photographs(tmp_path))) == []


def test_large_photographs_are_looked_at_a_few_at_a_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for number, side in enumerate((4, 20, 4, 4, 30)):
        write_png(tmp_path / f"{number}.png", torch.zeros(3, side, side))
    monkeypatch.setattr("lrsr.pictures.source._MOST_VALUES", 3 * 20 * 20)
    found = list(chunks(read_photographs(tmp_path, "probe")))
    assert [place for place, _ in found] == [slice(0, 2), slice(2, 5)]
    assert [[len(one.image[0]) for one in some] for _, some in found] == [[4, 20], [4, 4, 30]]


def test_pictures_of_several_sizes_keep_their_sizes(tmp_path: Path) -> None:
    photograph(tmp_path / "anna.png", 8, 6)
    photograph(tmp_path / "bert.png", 5, 9)
    pictures = read_photographs(tmp_path, "probe").load(0, 2)
    assert [tuple(one.image.shape) for one in pictures] == [(3, 8, 6), (3, 5, 9)]
    with pytest.raises(InputError, match="make no batch"):
        stack(pictures)


def test_landmarks_that_nobody_gave_are_not_known(tmp_path: Path) -> None:
    photograph(tmp_path / "anna.png")
    (picture,) = read_photographs(tmp_path, "probe").load(0, 1)
    assert picture.landmarks_px is None
    assert torch.isnan(stack([picture])[1]).all()  # a failure to acquire


def test_rendered_people_are_taken_where_the_cache_lacks_them(
    cache: RenderCache, maker: FakeMaker
) -> None:
    source = Rendered(SITTING.recipes(), Camera("heavy"), cache, maker, progress=False)
    assert list(source.identity_ids) == ["test-00000", "test-00001", "test-00002"]
    (second,) = source.load(1, 2)
    (taken,) = take_pictures(SITTING.recipes()[1:2], cache, Camera("heavy"), maker=maker)
    assert torch.equal(second.image, taken.image)
    assert len(maker.renders) == 1


def test_all_sources_are_rendered_at_once_and_photographs_are_there(
    folder: Path, cache: RenderCache, maker: FakeMaker
) -> None:
    recipes = replace(SITTING, seed=7).recipes()
    rendered = Rendered(recipes, Camera(), cache, maker, progress=False)
    photographs = read_photographs(folder, "probe")
    maker.renders.clear()
    assert render_sources([photographs, rendered, rendered]) == len(maker.renders) == 3
    assert render_sources([rendered]) == render_sources([photographs]) == 0


def frames_of(out: Path, cache: RenderCache, maker: FakeMaker, count: int) -> Photographs:
    """Photographs of what ``lrsr render frames=N scales=[1,2]`` writes."""
    settings = RenderSettings(out, BURSTS, Camera(), scales=(1, 2), frames=count)
    render_to_folder(settings, cache, progress=False, maker=maker)
    return read_photographs(out, "probe")


def test_a_burst_is_its_first_frame_with_the_others(
    tmp_path: Path, cache: RenderCache, maker: FakeMaker
) -> None:
    sources = [
        Rendered(BURSTS.recipes(frame=n), Camera(), cache, maker, progress=False) for n in range(3)
    ]
    rendered = Bursts(sources)
    assert render_sources([rendered]) == 9
    assert rendered.names == rendered.identity_ids == sources[0].identity_ids
    read = bursts_of(frames_of(tmp_path / "out", cache, maker, 3), 3)
    for source in (rendered, read):
        (burst,) = source.load(1, 2)
        frames = [burst, *burst.later]
        assert {one.identity_id for one in frames} == {"test-00001"}
        for one, frame in zip(frames, sources, strict=True):
            assert torch.equal(one.image, frame.load(1, 2)[0].image)


def test_a_folder_of_bursts_has_as_many_probes_as_people_and_a_reference_for_each_first_frame(
    tmp_path: Path, cache: RenderCache, maker: FakeMaker
) -> None:
    probes = frames_of(tmp_path / "out", cache, maker, 2)
    assert [entry.frame for entry in probes.entries] == [0, 0, 0]
    references = references_of(probes, 2)
    assert references is not None
    assert [(entry.frame, entry.scale) for entry in references.entries] == [(0, 2)] * 3


def test_a_burst_that_lacks_a_frame_is_refused(
    tmp_path: Path, cache: RenderCache, maker: FakeMaker
) -> None:
    probes = frames_of(tmp_path / "out", cache, maker, 2)
    with pytest.raises(InputError, match=r"has no frame 2: its manifest needs a row with frame=2"):
        bursts_of(probes, 3)
