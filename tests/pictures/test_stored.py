"""Everything that a file says of its picture comes back from the next file; oddities are named."""

import io
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image, ImageCms, ImageOps

from lrsr.errors import InputError
from lrsr.pictures.stored import FORMATS, Header, encode, read_header, read_stored

PATH = Path("a.picture")
PROFILE = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
MAKER, ORIENTATION, WHEN, WIDE, TALL, EXIF = 0x10F, 0x112, 0x9003, 0xA002, 0xA003, 0x8769


def noise(channels: int, depth: type = np.uint8) -> np.ndarray:
    rng = np.random.default_rng(2)
    return rng.integers(0, np.iinfo(depth).max, (12, 20, channels), depth, endpoint=True)


def said(orientation: int = 1) -> Image.Exif:
    exif = Image.Exif()
    exif[MAKER], exif[ORIENTATION] = "Camera", orientation
    exif[EXIF] = {WHEN: "2020:01:02 03:04:05", WIDE: 20, TALL: 12}
    whole = Image.Exif()
    whole.load(exif.tobytes())
    return whole


def saved(image: Image.Image, format: str, **told: Any) -> bytes:
    file = io.BytesIO()
    image.save(file, format, **told)
    return file.getvalue()


def passed_on(content: bytes, **told: Any) -> Image.Image:
    """Read, write unchanged, and let Pillow say what is there."""
    header, pixels, opacity = read_stored(content, PATH)
    settings: dict[str, Any] = {"format": header.format, "quality": 100} | told
    return Image.open(io.BytesIO(encode(pixels, opacity, header, **settings)))


@pytest.mark.parametrize("depth", [np.uint8, np.uint16])
@pytest.mark.parametrize("channels", [1, 3, 4])
@pytest.mark.parametrize("format", ["PNG", "TIFF"])
def test_every_bit_comes_back_with_exif_profile_and_resolution(
    format: str, channels: int, depth: type
) -> None:
    exif = {MAKER: "Camera", EXIF: {WHEN: "2020:01:02 03:04:05", WIDE: 20, TALL: 12}}
    header = Header(format, (12, 20), channels == 1, channels == 4, exif, PROFILE, (300, 300))
    bands = noise(channels, depth)
    pixels, opacity = (bands[..., :3], bands[..., 3:]) if channels == 4 else (bands, None)
    content = encode(pixels, opacity, header, format=format, quality=95)
    back, again, opaque = read_stored(content, PATH)
    np.testing.assert_array_equal(again, pixels)
    assert again.dtype == depth
    assert (opacity is None) is (opaque is None)
    if opacity is not None and opaque is not None:
        np.testing.assert_array_equal(opaque, opacity)
    assert (back.format, back.size_px, back.grey) == (format, (12, 20), channels == 1)
    assert back.profile == PROFILE
    assert back.dpi == pytest.approx((300, 300), abs=0.02)
    assert back.exif[MAKER] == "Camera"
    assert dict(back.exif[EXIF]) == {WHEN: "2020:01:02 03:04:05", WIDE: 20, TALL: 12}


@pytest.mark.parametrize("format", ["JPEG", "WEBP"])
def test_other_formats_keep_what_the_camera_said(format: str) -> None:
    told = {"exif": said(), "icc_profile": PROFILE, "quality": 90}
    image = passed_on(saved(Image.fromarray(noise(3)), format, **told))
    assert (image.format, image.info["icc_profile"]) == (format, PROFILE)
    assert image.getexif()[MAKER] == "Camera"


@pytest.mark.parametrize("orientation", range(1, 9))
@pytest.mark.parametrize(
    ("format", "mode"),
    [("JPEG", "RGB"), ("PNG", "RGBA"), ("WEBP", "RGBA"), ("TIFF", "RGBA"), ("TIFF", "RGB")],
)
def test_a_turned_picture_is_upright_and_says_so(format: str, mode: str, orientation: int) -> None:
    ramp = np.dstack([np.add.outer(3 * np.arange(12), 7 * np.arange(20))] * len(mode)).astype(
        np.uint8
    )
    told = {"lossless": True, "exact": True} if format == "WEBP" else {"quality": 100}
    content = saved(Image.fromarray(ramp), format, exif=said(orientation), **told)
    upright = np.asarray(ImageOps.exif_transpose(Image.open(io.BytesIO(content))))
    image = passed_on(content)
    assert read_header(content, PATH).size_px == upright.shape[:2]
    assert np.abs(np.asarray(image).astype(int) - upright).max() <= 2  # of JPEG, twice
    assert image.getexif().get(ORIENTATION, 1) == 1
    assert image.getexif()[MAKER] == "Camera"
    inner = image.getexif().get_ifd(EXIF)
    assert (inner[TALL], inner[WIDE]) == upright.shape[:2]


def test_deep_opacity_is_turned_with_its_picture() -> None:
    bands = noise(4, np.uint16)
    header = Header("PNG", (12, 20), grey=False, opacity=True)
    content = encode(bands[..., :3], bands[..., 3:], header, format="PNG", quality=95)
    exif = said(6).tobytes().removeprefix(b"Exif\0\0")
    chunk = len(exif).to_bytes(4) + b"eXIf" + exif + zlib.crc32(b"eXIf" + exif).to_bytes(4)
    _, pixels, opacity = read_stored(content[:33] + chunk + content[33:], PATH)
    np.testing.assert_array_equal(pixels, np.rot90(bands, -1)[..., :3])
    np.testing.assert_array_equal(opacity, np.rot90(bands, -1)[..., 3:])


@pytest.mark.parametrize(
    ("image", "told", "mode"),
    [
        (Image.fromarray(noise(1)[..., 0]), {}, "L"),
        (Image.fromarray(noise(2)), {}, "LA"),
        (Image.fromarray(noise(1)[..., 0]), {"transparency": 7}, "LA"),
        (Image.fromarray(noise(3)), {"transparency": (1, 2, 3)}, "RGBA"),
        (Image.fromarray(noise(3)).quantize(8), {}, "RGB"),
        (Image.fromarray(noise(3)).quantize(8), {"transparency": 3}, "RGBA"),
        (Image.fromarray(noise(1)[..., 0] > 90), {}, "L"),
        (Image.fromarray(noise(1, np.uint16)[..., 0]), {}, "I;16"),
    ],
    ids=["grey", "glass", "a clear grey", "a clear colour", "palette", "clear one", "bits", "deep"],
)
def test_every_kind_of_pixels_is_seen_as_it_is(
    image: Image.Image, told: dict[str, Any], mode: str
) -> None:
    content = saved(image, "PNG", **told)
    got = passed_on(content)
    assert got.mode.replace("I;16B", "I;16") == mode
    if mode != "I;16":
        shown = np.asarray(Image.open(io.BytesIO(content)).convert("RGBA"))
        np.testing.assert_array_equal(np.asarray(got.convert("RGBA")), shown)


def test_grey_with_opacity_of_16_bits_becomes_colours() -> None:
    bands = noise(2, np.uint16)
    header = Header("PNG", (12, 20), grey=True, opacity=True, profile=PROFILE)
    content = encode(bands[..., :1], bands[..., 1:], header, format="PNG", quality=95)
    _, pixels, opacity = read_stored(content, PATH)
    np.testing.assert_array_equal(pixels, bands[..., [0, 0, 0]])
    np.testing.assert_array_equal(opacity, bands[..., 1:])
    assert read_header(content, PATH).profile is None  # it is of grey


@pytest.mark.parametrize("format", ["JPEG", "WEBP", "BMP", "PPM"])
def test_other_formats_round_16_bits_or_keep_them(format: str) -> None:
    bands = np.repeat(np.repeat(noise(3, np.uint16)[:2, :2], 8, 0), 8, 1)
    header = Header("PNG", (16, 16), grey=False, opacity=False)
    file = encode(bands, None, header, format=format, quality=100)
    _, pixels, _ = read_stored(file, PATH)
    assert pixels.dtype == (np.uint16 if format == "PPM" else np.uint8)
    levels = np.iinfo(pixels.dtype).max
    assert np.abs(pixels / levels - bands / 65535)[4:-4, 4:-4].mean() < 0.03


def test_quality_decides_about_the_size() -> None:
    header = Header("JPEG", (12, 20), grey=False, opacity=False)
    sizes = [len(encode(noise(3), None, header, format="JPEG", quality=q)) for q in (20, 95)]
    assert sizes[0] < sizes[1]


def test_a_picture_with_previews_is_the_first_of_them() -> None:
    """Telephones and cameras store MPO: JPEG, and further ones behind it."""
    images = [Image.fromarray(noise(3)), Image.new("RGB", (5, 5))]
    content = saved(images[0], "MPO", save_all=True, append_images=images[1:])
    header, pixels, _ = read_stored(content, PATH)
    assert (header.format, pixels.shape) == ("JPEG", (12, 20, 3))


def frames(format: str) -> bytes:
    images = [Image.fromarray(noise(3) // k) for k in (1, 2, 3)]
    return saved(images[0], format, save_all=True, append_images=images[1:])


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (frames("PNG"), "holds 3 pictures: give each as a file of its own"),
        (frames("WEBP"), "holds 3 pictures"),
        (frames("TIFF"), "holds 3 pictures"),
        (saved(Image.fromarray(noise(3)), "GIF"), "is GIF: convert it to one of png, jpg"),
        (saved(Image.new("CMYK", (5, 5)), "JPEG"), "is CMYK, no grey or RGB picture: convert it"),
        (saved(Image.new("F", (5, 5)), "TIFF"), "is F, no grey or RGB picture"),
        (b"", "is no picture, or a broken one"),
        (b"no picture", "is no picture, or a broken one"),
    ],
    ids=["png", "webp", "tiff", "gif", "cmyk", "float", "empty", "text"],
)
def test_what_cannot_be_enlarged_is_named_by_its_header(content: bytes, says: str) -> None:
    with pytest.raises(InputError, match=says):
        read_header(content, PATH)


@pytest.mark.parametrize("format", FORMATS.values())
def test_a_picture_cut_short_is_refused(format: str) -> None:
    content = saved(Image.fromarray(np.tile(noise(3), (5, 5, 1))), format)
    with pytest.raises(InputError, match=r"a\.picture is .*(broken|no picture)"):
        read_stored(content[: len(content) * 2 // 3], PATH)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"a\.png does not exist"):
        read_header(tmp_path / "a.png", tmp_path / "a.png")


def test_more_pixels_than_can_be_read_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Image, "MAX_IMAGE_PIXELS", 100)
    with pytest.raises(InputError, match="has more pixels than can be read"):
        read_header(saved(Image.fromarray(noise(3)), "PNG"), PATH)


def test_one_clear_grey_of_16_bits_is_refused() -> None:
    grey = saved(Image.fromarray(noise(1, np.uint16)[..., 0]), "PNG", transparency=7)
    with pytest.raises(InputError, match="16 bits and an opacity that lrsr cannot read"):
        read_stored(grey, PATH)


def test_what_a_format_cannot_hold_is_named() -> None:
    header = Header("JPEG", (1, 70_000), grey=True, opacity=False)
    long = np.zeros((1, 70_000, 1), np.uint8)
    with pytest.raises(InputError, match=r"70000x1 px of L are no JPEG .*: give format=png"):
        encode(long, None, header, format="JPEG", quality=95)
