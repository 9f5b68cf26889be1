"""A rendering is kept whole, found again, and never believed when it is damaged."""

import errno
import logging
import os
from dataclasses import asdict, fields, replace
from pathlib import Path

import pytest
import torch
from fakes.elsewhere import finish, run_script

from lrsr.errors import ImageContractError, InputError, NonFiniteError
from lrsr.identities.person import Traits
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.recipe import digest
from lrsr.rendering.radiance import Radiance
from lrsr.spectra import band_edges

KEY = digest({"who": 1})


def radiance(height: int = 4, width: int = 6, seed: int = 0) -> Radiance:
    generator = torch.Generator().manual_seed(seed)
    return Radiance(
        image=torch.rand(3, height, width, generator=generator),
        landmarks_px=torch.rand(5, 2, generator=generator),
        ipd_px=8.0,
        scale=2,
        metered=1.25,
        traits=Traits("female", 41.5, {"asian": 1.0}, 30.0, "léger"),
    )


def same(a: Radiance | None, b: Radiance) -> bool:
    assert a is not None
    tensors = ("image", "landmarks_px")
    names = [field.name for field in fields(b) if field.name not in tensors]
    return all(torch.equal(getattr(a, name), getattr(b, name)) for name in tensors) and all(
        getattr(a, name) == getattr(b, name) for name in names
    )


def entry(cache: RenderCache) -> Path:
    cache.put(KEY, radiance())
    return cache.path(KEY)


def test_what_was_put_is_got_bit_for_bit(cache: RenderCache) -> None:
    cache.put(KEY, radiance())
    assert same(cache.get(KEY), radiance())


def test_who_a_picture_shows_is_kept_with_it(cache: RenderCache) -> None:
    gate = {"redraws": 2, "failures": [["size"], ["size", "hair"]]}
    traits = Traits("male", 61.5, {"african": 0.5, "asian": 0.5}, -12.0, "brown", gate)
    cache.put(KEY, replace(radiance(), traits=traits))
    found = cache.get(KEY)
    assert found is not None
    assert found.traits == traits


def test_who_it_shows_need_not_be_known(cache: RenderCache) -> None:
    cache.put(KEY, replace(radiance(), traits=None))
    assert same(cache.get(KEY), replace(radiance(), traits=None))


def test_bands_are_kept_with_their_edges_and_the_meters_light(cache: RenderCache) -> None:
    bands = replace(
        radiance(),
        image=torch.rand(7, 4, 6),
        edges_nm=band_edges(7),
        metered_bands=(0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7),
    )
    cache.put(KEY, bands)
    assert same(cache.get(KEY), bands)
    with pytest.raises(ImageContractError, match=r"wanted \(B, 7, H, W\)"):
        cache.put(KEY, replace(bands, image=torch.rand(3, 4, 6)))


def test_an_entry_from_before_the_gate_was_recorded_is_still_read(
    cache: RenderCache, monkeypatch: pytest.MonkeyPatch
) -> None:
    traits = Traits("male", 61.5, {"asian": 1.0}, -12.0, "brown", {"redraws": 0})
    told = {name: value for name, value in asdict(traits).items() if name != "gate"}
    with monkeypatch.context() as patch:
        patch.setattr("lrsr.pictures.cache.asdict", lambda _: told)
        cache.put(KEY, replace(radiance(), traits=traits))
    found = cache.get(KEY)
    assert found is not None
    assert found.traits == replace(traits, gate=None)


def test_views_of_larger_tensors_are_kept_as_what_they_show(cache: RenderCache) -> None:
    turned = replace(radiance(), image=torch.rand(6, 4, 3).permute(2, 1, 0)[:, ::2])
    cache.put(KEY, turned)
    assert same(cache.get(KEY), turned)


def test_nothing_is_found_where_nothing_was_put(cache: RenderCache) -> None:
    assert cache.get(KEY) is None
    assert not cache.folder.exists()


def test_an_entry_lies_under_the_first_digits_of_its_key(cache: RenderCache) -> None:
    entry(cache)
    assert [path.relative_to(cache.folder) for path in cache.folder.rglob("*.*")] == [
        Path(KEY[:2], f"{KEY}.safetensors")
    ]


def test_every_flipped_byte_is_noticed_or_harmless(cache: RenderCache) -> None:
    path = entry(cache)
    whole = path.read_bytes()
    noticed = 0
    for place in range(len(whole)):
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 0x11]) + whole[place + 1 :])
        found = RenderCache(cache.folder).get(KEY)
        assert found is None or same(found, radiance()), f"byte {place} lies"
        noticed += found is None
    assert noticed > 0.95 * len(whole)


@pytest.mark.parametrize("length", [0, 1, 7, 8, 9, 100, -1], ids=str)
def test_a_truncated_entry_counts_as_none(cache: RenderCache, length: int) -> None:
    path = entry(cache)
    path.write_bytes(path.read_bytes()[:length])
    assert cache.get(KEY) is None


def test_an_entry_of_another_programme_counts_as_none(cache: RenderCache) -> None:
    entry(cache).write_bytes(b"\x02\x00\x00\x00\x00\x00\x00\x00{}")
    assert cache.get(KEY) is None


def test_a_damaged_entry_is_reported_once_and_replaced(
    cache: RenderCache, caplog: pytest.LogCaptureFixture
) -> None:
    path = entry(cache)
    path.write_bytes(path.read_bytes()[:-1] + b"\x00")
    with caplog.at_level(logging.WARNING):
        assert cache.get(KEY) is None
        assert cache.get(KEY) is None
    assert len(caplog.messages) == 1
    assert f"damaged cache entry {path}" in caplog.messages[0]
    cache.put(KEY, radiance())
    assert same(cache.get(KEY), radiance())


def test_a_full_disk_is_one_line_and_leaves_nothing(
    cache: RenderCache, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(path: Path, content: bytes) -> int:
        with path.open("wb") as file:
            file.write(content[:10])
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(InputError, match="No space left on device; free space or choose") as caught:
        cache.put(KEY, radiance())
    assert "\n" not in str(caught.value)
    assert [path for path in cache.folder.rglob("*") if path.is_file()] == []


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_a_picture_with_holes_is_not_kept(cache: RenderCache, value: float) -> None:
    holed = radiance()
    holed.image[0, 0, 0] = value
    with pytest.raises(NonFiniteError, match=f"rendering {KEY[:12]}"):
        cache.put(KEY, holed)
    assert cache.get(KEY) is None


def test_a_picture_of_the_wrong_shape_is_not_kept(cache: RenderCache) -> None:
    with pytest.raises(ImageContractError, match=f"rendering {KEY[:12]}: got shape"):
        cache.put(KEY, replace(radiance(), image=torch.zeros(4, 4)))


def test_a_folder_that_is_a_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match=r"cache folder .*file is a file: choose another folder"):
        RenderCache(tmp_path / "file")


def test_an_entry_that_cannot_be_read_is_the_users_to_mend(cache: RenderCache) -> None:
    cache.path(KEY).mkdir(parents=True)
    with pytest.raises(InputError, match=r"cannot read .*\.safetensors: a folder, not a file"):
        cache.get(KEY)


def test_sweeping_removes_unfinished_files_and_no_entry(cache: RenderCache) -> None:
    path = entry(cache)
    path.with_name(f".{path.name}.01234567.part").touch()
    assert cache.sweep() == 1
    assert [found.name for found in path.parent.iterdir()] == [path.name]
    assert RenderCache(cache.folder / "none").sweep() == 0


def test_the_same_picture_is_the_same_bytes(cache: RenderCache) -> None:
    whole = entry(cache).read_bytes()
    for _ in range(10):
        assert entry(cache).read_bytes() == whole


THREE_WRITERS = """
import os, sys
from pathlib import Path
import torch
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.recipe import digest
from lrsr.rendering.radiance import Radiance

key, cache = digest({"who": 1}), RenderCache(Path(sys.argv[1]))
image = torch.arange(3 * 64 * 64).reshape(3, 64, 64).float()
picture = Radiance(image, torch.zeros(5, 2), 8.0, 1, 1.0)
for _ in range(3):
    if os.fork() == 0:
        status = 1
        try:
            for _ in range(60):
                cache.sweep()
                cache.put(key, picture)
                if not torch.equal(cache.get(key).image, picture.image):
                    raise ValueError("another picture")
            status = 0
        finally:
            os._exit(status)
sys.exit(sum(os.wait()[1] != 0 for _ in range(3)))
"""


def test_processes_that_write_the_same_entry_never_see_half_of_it(tmp_path: Path) -> None:
    folder = tmp_path / "cache"
    ended = finish(tmp_path / "told", run_script, THREE_WRITERS, str(folder))
    assert (ended.status, ended.err) == (0, "")
    assert [path.name for path in folder.rglob("*.*")] == [f"{KEY}.safetensors"]
