"""Folders and files of pictures, as people have them: names, resuming, refusals."""

import os
from pathlib import Path

import numpy as np
import pytest
import torch
from PIL import Image

from lrsr.errors import InputError
from lrsr.experiments import upscaling
from lrsr.experiments.upscaling import Upscaling
from lrsr.pictures.stored import encode
from lrsr.sr import Bicubic


class Counted(Bicubic):
    """Bicubic that counts what it is given."""

    seen = 0

    def _enlarge(self, srgb: torch.Tensor) -> torch.Tensor:
        self.seen += 1
        return super()._enlarge(srgb)


def picture(path: Path, mode: str = "RGB", seed: int = 0) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng(seed)
    Image.fromarray(rng.integers(0, 255, (6, 9, len(mode)), np.uint8).squeeze()).save(path)
    return path


def run(out: Path, *images: Path, scale: int = 2, **settings: object) -> int:
    """Enlarge; return how many pictures the upscaler saw."""
    upscaler = Counted(scale)
    out.mkdir(exist_ok=True)
    Upscaling(images, upscaler, **settings).run(out, progress=False)  # type: ignore[arg-type]
    return upscaler.seen


def refusals(out: Path, *images: Path, **settings: object) -> list[str]:
    with pytest.raises(ExceptionGroup) as caught:
        run(out, *images, **settings)  # type: ignore[arg-type]
    return [str(error) for error in caught.value.exceptions]


def opened(path: Path) -> Image.Image:
    with Image.open(path) as image:
        image.load()
    return image


def made(out: Path) -> dict[str, tuple[int, int]]:
    files = {p for p in out.rglob("*") if p.is_file() and p.suffix != ".jsonl"}
    return {p.relative_to(out).as_posix(): opened(p).size for p in sorted(files)}


def test_files_and_folders_keep_their_names(tmp_path: Path) -> None:
    one = picture(tmp_path / "x" / "one.JPG")
    for name in ("a.png", "sub/a.png", "sub/deep/b.webp", ".hidden/c.png", "d.txt.png"):
        picture(tmp_path / "h" / name)
    (tmp_path / "h" / "notes.txt").write_text("no picture")
    run(tmp_path / "out", one, tmp_path / "h", scale=3)
    names = ["a.png", "d.txt.png", "one.JPG", "sub/a.png", "sub/deep/b.webp"]
    assert made(tmp_path / "out") == dict.fromkeys(names, (27, 18))


def test_a_name_of_strange_bytes_is_refused_and_the_others_are_finished(tmp_path: Path) -> None:
    for name in ("a.png", "c.png"):
        picture(tmp_path / "h" / name)
    strange = tmp_path / "h" / os.fsdecode(b"b\xff.png")
    strange.write_bytes((tmp_path / "h" / "a.png").read_bytes())
    with pytest.raises(ExceptionGroup) as refused:
        run(tmp_path / "out", tmp_path / "h", scale=3)
    (error,) = refused.value.exceptions
    assert isinstance(error, InputError)
    assert str(error).endswith(r"b\udcff.png': a name of other bytes than UTF-8; rename it")
    assert [*made(tmp_path / "out")] == ["a.png", "c.png"]


def test_several_folders_become_folders(tmp_path: Path) -> None:
    folders = [picture(tmp_path / name / "a.png").parent for name in ("h", "i")]
    run(tmp_path / "out", *folders)
    assert list(made(tmp_path / "out")) == ["h/a.png", "i/a.png"]


def test_pictures_of_one_name_do_not_meet_and_keep_their_names(tmp_path: Path) -> None:
    files = [picture(tmp_path / "h" / f"a.{kind}") for kind in ("jpg", "png")]
    elsewhere = picture(tmp_path / "i" / "a.png", seed=1)
    out = tmp_path / "out"
    run(out, files[1], format="webp")
    assert run(out, files[0].parent, elsewhere, files[1], format="webp") == 2
    assert list(made(out)) == ["a-2.webp", "a-3.webp", "a.webp"]
    assert run(out, files[0].parent, elsewhere, format="webp") == 0


def test_a_name_follows_the_format(tmp_path: Path) -> None:
    Image.new("RGB", (4, 4)).save(tmp_path / "a.png", "JPEG")
    Image.new("RGB", (4, 4)).save(tmp_path / "b.jpeg")
    run(tmp_path / "out", tmp_path / "a.png", tmp_path / "b.jpeg")
    run(tmp_path / "jpg", tmp_path / "b.jpeg", format="jpg")
    assert [*made(tmp_path / "out"), *made(tmp_path / "jpg")] == ["a.jpg", "b.jpeg", "b.jpeg"]


def test_what_is_done_is_not_done_again_what_changed_is(tmp_path: Path) -> None:
    files = [picture(tmp_path / name) for name in ("a.png", "b.png")]
    out = tmp_path / "out"
    assert run(out, *files) == 2
    before = {path: path.stat().st_mtime_ns for path in out.glob("*.png")}
    assert run(out, *files) == 0
    assert {path: path.stat().st_mtime_ns for path in out.glob("*.png")} == before
    picture(files[0], seed=5)
    assert run(out, *files) == 1
    assert run(out, *files, scale=4) == 2
    assert made(out) == {"a.png": (36, 24), "b.png": (36, 24)}


def test_an_interrupted_run_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    files = [picture(tmp_path / f"{name}.png") for name in "abc"]
    calls: list[int] = []

    def interrupted(*args: object, **more: object) -> bytes:
        calls.append(1)
        if len(calls) == 2:
            raise KeyboardInterrupt
        return encode(*args, **more)  # type: ignore[arg-type]

    monkeypatch.setattr(upscaling, "encode", interrupted)
    with pytest.raises(KeyboardInterrupt):
        run(tmp_path / "out", *files)
    assert list(made(tmp_path / "out")) == ["a.png"]
    assert run(tmp_path / "out", *files) == 2


def test_what_somebody_put_there_stays(tmp_path: Path) -> None:
    one, other = picture(tmp_path / "a.png"), picture(tmp_path / "b.png")
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "a.png").write_bytes(b"precious")
    (line,) = refusals(tmp_path / "out", one, other)
    assert "out/a.png is there, and lrsr upscale did not make it so: move it" in line
    assert (tmp_path / "out" / "a.png").read_bytes() == b"precious"
    assert opened(tmp_path / "out" / "b.png").size == (18, 12)


def test_pictures_are_never_their_own_results(tmp_path: Path) -> None:
    picture(tmp_path / "a.png")
    lines = refusals(tmp_path, tmp_path)
    assert len(lines) == 1
    assert opened(tmp_path / "a.png").size == (9, 6)
    for _ in range(2):  # nor what was made of them in a folder among them
        run(tmp_path / "out", tmp_path)
        assert list(made(tmp_path / "out")) == ["a.png"]


def test_the_broken_are_refused_and_the_others_done(tmp_path: Path) -> None:
    picture(tmp_path / "h" / "good.png")
    (tmp_path / "h" / "text.png").write_text("no picture")
    whole = picture(tmp_path / "h" / "cut.png").read_bytes()
    (tmp_path / "h" / "cut.png").write_bytes(whole[: len(whole) // 2])
    picture(tmp_path / "h" / "glass.png", "RGBA")
    lines = refusals(tmp_path / "out", tmp_path / "h", tmp_path / "gone.png", format="jpg")
    said = [
        "glass.png has transparent parts, JPEG none: give format=png",
        "text.png is no picture, or a broken one",
        "gone.png does not exist",
        "cut.png is a broken picture",
    ]
    assert all(
        part in line
        for part, line in zip(
            sorted(said), sorted(lines, key=lambda t: t.rsplit("/")[-1]), strict=True
        )
    )
    assert list(made(tmp_path / "out")) == ["good.jpg"]


def test_too_large_a_result_is_refused_before_any_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(upscaling, "_MOST_PX", 200)
    (line,) = refusals(tmp_path / "out", picture(tmp_path / "a.png"))
    assert "a.png would have 0 million pixels, over 0: give a smaller picture or scale" in line


@pytest.mark.parametrize(
    ("fault", "says"),
    [
        (MemoryError(), "does not fit into memory"),
        (float("nan"), ": give other weights"),
    ],
)
def test_what_a_network_cannot_do_is_told_of_its_picture(
    tmp_path: Path, fault: MemoryError | float, says: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(self: object, srgb: torch.Tensor) -> torch.Tensor:
        if isinstance(fault, MemoryError):
            raise fault
        return torch.full((1, 3, 12, 18), fault)

    monkeypatch.setattr(Counted, "_enlarge", fail)
    (line,) = refusals(tmp_path / "out", picture(tmp_path / "a.png"))
    assert "a.png" in line
    assert says in line


def test_opacity_goes_up_and_hidden_colours_stay_out_of_sight(tmp_path: Path) -> None:
    bands = np.zeros((8, 8, 4), np.uint8)
    bands[:, :4] = (200, 100, 50, 255)
    Image.fromarray(bands).save(tmp_path / "a.png")
    run(tmp_path / "out", tmp_path / "a.png")
    large = np.asarray(opened(tmp_path / "out" / "a.png"))
    seen = large[large[..., 3] > 0]
    assert (seen[:, :3] == (200, 100, 50)).all()
    assert large[0, :, 3].tolist()[:6] + large[0, :, 3].tolist()[-6:] == [255] * 6 + [0] * 6


def test_tiles_change_no_picture(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    Image.fromarray(rng.integers(0, 255, (40, 50, 4), np.uint8)).save(tmp_path / "a.png")
    for name, tile_px in (("tiles", 16), ("whole", None)):
        run(tmp_path / name, tmp_path / "a.png", tile_px=tile_px)
    tiled, whole = (np.asarray(opened(tmp_path / n / "a.png")) for n in ("tiles", "whole"))
    np.testing.assert_array_equal(tiled, whole)


@pytest.mark.parametrize(
    ("settings", "says"),
    [
        ({"format": "gif"}, "format=gif: wanted null or one of png, jpg"),
        ({"quality": 0}, "quality=0: wanted 1 to 100"),
        ({"tile_px": 8}, "tile_px=8: wanted 16 or more"),
        ({"around_px": -1}, "around_px=-1: wanted 0 or more"),
    ],
)
def test_settings_out_of_range_are_named(settings: dict[str, object], says: str) -> None:
    with pytest.raises(InputError, match=says):
        Upscaling((), Bicubic(2), **settings)  # type: ignore[arg-type]


def test_a_folder_without_pictures_is_named(tmp_path: Path) -> None:
    (tmp_path / "h").mkdir()
    with pytest.raises(InputError, match=r"images=.*h holds no pictures: put files in it \(png"):
        run(tmp_path / "out", tmp_path / "h")


def test_a_full_disk_stops_the_work_at_the_first_picture(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in "abc":
        picture(tmp_path / "h" / f"{name}.png")
    upscaler = Counted(2)

    def full(path: Path, *_: object, **__: object) -> None:
        raise InputError(f"cannot write {path}: No space left on device; free space")

    monkeypatch.setattr("lrsr.experiments.made.write_bytes", full)
    (tmp_path / "out").mkdir()
    with pytest.raises(InputError, match=r"cannot write .*out/a\.png: No space left"):
        Upscaling((tmp_path / "h",), upscaler).run(tmp_path / "out", progress=False)
    assert upscaler.seen == 1
