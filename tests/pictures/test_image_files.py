"""A picture goes into a file and comes back; what is no picture is refused in one line."""

import errno
import os
import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from PIL import Image

from lrsr.errors import ImageContractError, InputError, NonFiniteError
from lrsr.pictures.image_files import SUFFIXES, read_image, write_png


def picture(levels: int) -> torch.Tensor:
    whole = torch.randint(0, levels + 1, (3, 5, 7), generator=torch.Generator().manual_seed(0))
    return whole / levels


@pytest.mark.parametrize(("bits", "levels"), [(8, 255), (16, 65535)])
def test_a_picture_comes_back_bit_for_bit(tmp_path: Path, bits: int, levels: int) -> None:
    write_png(tmp_path / "a.png", picture(levels), bits=bits)
    back = read_image(tmp_path / "a.png")
    assert back.dtype == torch.float32
    assert torch.equal((back * levels).round(), (picture(levels) * levels).round())


def test_red_is_red_to_others(tmp_path: Path) -> None:
    red = torch.zeros(3, 2, 2)
    red[0] = 1.0
    write_png(tmp_path / "a.png", red)
    assert np.asarray(Image.open(tmp_path / "a.png"))[0, 0].tolist() == [255, 0, 0]


def test_rows_are_rows(tmp_path: Path) -> None:
    Image.fromarray(np.arange(6, dtype=np.uint8).reshape(2, 3)).save(tmp_path / "a.png")
    assert (read_image(tmp_path / "a.png")[0] * 255).tolist() == [[0, 1, 2], [3, 4, 5]]


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_every_kind_of_file_that_is_taken_for_a_picture_can_be_read(
    tmp_path: Path, suffix: str
) -> None:
    shades = np.linspace(40, 220, 16, dtype=np.uint8)
    rgb = np.stack([np.tile(shades, (16, 1)), np.tile(shades[:, None], (1, 16))] * 2, -1)[..., :3]
    Image.fromarray(rgb).save(tmp_path / f"a{suffix}", **({"quality": 95} if "j" in suffix else {}))
    seen = read_image(tmp_path / f"a{suffix}").permute(1, 2, 0).numpy() * 255
    assert np.abs(seen - rgb).mean() < 6


def test_a_picture_is_turned_as_its_exif_says(tmp_path: Path) -> None:
    """Telephones store portraits lying on their side."""
    lying = Image.fromarray(np.tile(np.array([[0], [255]], np.uint8), (8, 32)))
    exif = Image.Exif()
    exif[0x0112] = 6  # Orientation: turn right by 90°
    lying.save(tmp_path / "a.jpg", exif=exif)
    assert read_image(tmp_path / "a.jpg").shape == (3, 32, 16)


def test_grey_becomes_three_channels_and_opacity_is_left_out(tmp_path: Path) -> None:
    for mode, name in (("L", "grey.png"), ("RGBA", "glass.png")):
        Image.new(mode, (4, 3), 128 if mode == "L" else (128, 128, 128, 7)).save(tmp_path / name)
        assert read_image(tmp_path / name).mul(255).unique().tolist() == [128.0]


@pytest.mark.parametrize("compression", [None, "tiff_lzw"])
def test_a_transparent_tiff_has_the_colours_of_its_file(
    tmp_path: Path, compression: str | None
) -> None:
    glass = Image.new("RGBA", (4, 3), (200, 100, 50, 7))
    exif = Image.Exif()
    exif[0x0112] = 6
    glass.save(tmp_path / "glass.tif", compression=compression, exif=exif)
    image = read_image(tmp_path / "glass.tif")
    assert image.shape == (3, 4, 3)
    assert image[:, 1, 1].mul(255).round().tolist() == [200, 100, 50]


def test_a_transparent_tiff_that_is_cut_short_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "glass.tif"
    Image.effect_noise((64, 64), 90).convert("RGBA").save(path)
    path.write_bytes(path.read_bytes()[:-900])
    with pytest.raises(InputError, match=r"glass\.tif"):
        read_image(path)


def test_what_lies_outside_is_clipped(tmp_path: Path) -> None:
    write_png(tmp_path / "a.png", torch.tensor([-1.0, 0.5, 2.0])[:, None, None])
    assert (read_image(tmp_path / "a.png") * 255).flatten().tolist() == [0, 128, 255]


@pytest.mark.parametrize("content", [b"", b"no picture", None], ids=["empty", "text", "half"])
def test_a_broken_picture_is_named(tmp_path: Path, content: bytes | None) -> None:
    path = tmp_path / "a.png"
    write_png(path, picture(255))
    path.write_bytes(path.read_bytes()[:40] if content is None else content)
    with pytest.raises(InputError, match=r"a\.png is no picture, or a broken one: make it again"):
        read_image(path)


def test_a_name_of_strange_bytes_is_refused(tmp_path: Path) -> None:
    with pytest.raises(
        InputError, match=r"b\\udcff\.png': a name of other bytes than UTF-8; rename"
    ):
        read_image(tmp_path / os.fsdecode(b"b\xff.png"))


def test_a_missing_picture_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"cannot read .*a\.png: No such file or directory"):
        read_image(tmp_path / "a.png")


def test_only_8_and_16_bits(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="bits=12: wanted 8 or 16"):
        write_png(tmp_path / "a.png", picture(255), bits=12)


def test_a_full_disk_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(InputError, match=r"cannot write .*a\.png: No space left on device"):
        write_png(tmp_path / "a.png", picture(255))
    assert list(tmp_path.iterdir()) == []


def test_more_pixels_than_can_be_read_are_one_line(tmp_path: Path) -> None:
    header = struct.pack(">IIBBBBB", 40_000, 40_000, 8, 2, 0, 0, 0)
    file = b"\x89PNG\r\n\x1a\n"
    for kind, content in ((b"IHDR", header), (b"IDAT", zlib.compress(b"")), (b"IEND", b"")):
        check = zlib.crc32(kind + content)
        file += struct.pack(">I", len(content)) + kind + content + struct.pack(">I", check)
    (tmp_path / "huge.png").write_bytes(file)
    with pytest.raises(InputError, match=r"cannot read .*huge\.png: .*; make it smaller"):
        read_image(tmp_path / "huge.png")


@pytest.mark.parametrize(
    "image",
    [
        torch.zeros(3, 4, 4, dtype=torch.uint8),  # would be white, or black
        torch.zeros(4, 4, 3),
        torch.zeros(1, 3, 4, 4),
        np.zeros((3, 4, 4), np.float32),
        torch.zeros(3, 4, 4, dtype=torch.bfloat16),
    ],
    ids=["whole numbers", "channels last", "a batch", "NumPy", "bfloat16"],
)
def test_what_is_no_picture_is_not_written(tmp_path: Path, image: Any) -> None:
    with pytest.raises(ImageContractError, match="image: got"):
        write_png(tmp_path / "a.png", image)
    with pytest.raises(NonFiniteError):
        write_png(tmp_path / "a.png", torch.full((3, 2, 2), float("nan")))
    assert list(tmp_path.iterdir()) == []
