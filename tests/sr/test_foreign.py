"""Networks of others: as spandrel runs them, padded as they want, and never run by a pickle."""

import pickle
import warnings
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import torch
from safetensors.torch import save_file

from lrsr.errors import InputError
from lrsr.images import resize_bicubic
from lrsr.sr import Foreign, foreign, load_upscaler
from lrsr.sr.large import enlarge


@pytest.fixture(scope="module")
def spandrel() -> object:
    with warnings.catch_warnings(action="ignore"):
        return pytest.importorskip("spandrel", reason="spandrel is an extra: pip install lrsr[sr]")


def compact(scale: int, channels: int = 3) -> dict[str, torch.Tensor]:
    """Weights of an SRVGGNetCompact (Real-ESRGAN's small one): 8 features, one inner layer."""
    torch.manual_seed(scale)
    sizes = [(8, channels), (8, 8), (channels * scale**2, 8)]
    state = {}
    for number, (out, into) in enumerate(sizes):
        state[f"body.{2 * number}.weight"] = 0.2 * torch.randn(out, into, 3, 3)
        state[f"body.{2 * number}.bias"] = 0.2 * torch.randn(out)
        if number < 2:
            state[f"body.{2 * number + 1}.weight"] = torch.rand(8)
    return state


def compact_by_hand(srgb: torch.Tensor, state: dict[str, torch.Tensor], scale: int) -> torch.Tensor:
    """Wang et al., Real-ESRGAN (2021): convolutions with PReLU, a shuffle, nearest around all."""
    f = torch.nn.functional
    x = srgb
    for number in range(3):
        x = f.conv2d(
            x, state[f"body.{2 * number}.weight"], state[f"body.{2 * number}.bias"], padding=1
        )
        x = f.prelu(x, state[f"body.{2 * number + 1}.weight"]) if number < 2 else x
    return (f.pixel_shuffle(x, scale) + f.interpolate(srgb, scale_factor=scale)).clamp(0, 1)


@pytest.fixture
def saved(spandrel: object, tmp_path: Path) -> Callable[..., Path]:
    def save(state: object, name: str = "theirs.pth") -> Path:
        path = tmp_path / name
        if name.endswith(".safetensors"):
            save_file(state, path)
        else:
            torch.save(state, path)
        return path

    return save


@pytest.fixture
def faces() -> torch.Tensor:
    return torch.rand(3, 3, 9, 7, generator=torch.Generator().manual_seed(5))


@pytest.mark.parametrize("scale", [2, 4])
@pytest.mark.parametrize(
    ("name", "wrapped"),
    [("w.pth", "params_ema"), ("w.pth", ""), ("w.pt", "params"), ("w.safetensors", "")],
)
def test_the_pixels_are_those_of_the_architecture_written_out(
    saved: Callable[..., Path], faces: torch.Tensor, name: str, wrapped: str, scale: int
) -> None:
    state = compact(scale)
    upscaler = Foreign(saved({wrapped: state} if wrapped else state, name))
    torch.testing.assert_close(
        upscaler(faces), compact_by_hand(faces, state, scale), rtol=0, atol=1e-5
    )
    assert (upscaler.label, upscaler.scale, upscaler.learned) == ("w", scale, True)


@pytest.mark.parametrize("name", ["w.pth", "w.safetensors"])
def test_weights_tell_what_they_are(saved: Callable[..., Path], name: str) -> None:
    """As ``sr.mine.weights=FILE`` of lrsr eval and demo."""
    upscaler = load_upscaler(saved(compact(2), name), "Theirs")
    assert isinstance(upscaler, Foreign)
    told = upscaler.describe()
    assert (told["label"], told["scale"], told["file"]) == ("Theirs", 2, name)
    assert (told["kind"], told["kernel"]) == ("foreign, SR", "")
    assert str(told["architecture"]).startswith("RealESRGAN Compact (spandrel 0.")
    assert len(str(told["sha256"])) == 64


def test_what_restores_sees_the_enlarged_picture(
    saved: Callable[..., Path], faces: torch.Tensor
) -> None:
    state = compact(1)
    upscaler = Foreign(saved(state), scale=4)
    larger = resize_bicubic(faces, 4).clamp(0, 1)
    torch.testing.assert_close(
        upscaler(faces), compact_by_hand(larger, state, 1), rtol=0, atol=1e-5
    )
    assert Foreign(saved(state)).scale == 1
    assert "Keys" in str(upscaler.describe()["kernel"])


def test_sizes_that_a_network_wants_are_met_by_padding(
    saved: Callable[..., Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    upscaler = Foreign(saved(compact(2)))
    from spandrel import SizeRequirements

    seen: list[tuple[int, ...]] = []
    call = upscaler._network._call_fn

    def watched(model: object, image: torch.Tensor) -> torch.Tensor:
        seen.append(tuple(image.shape))
        restored: torch.Tensor = call(model, image)
        return restored

    wants = SizeRequirements(16, multiple_of=8, square=True)
    monkeypatch.setattr(upscaler._network, "size_requirements", wants)
    monkeypatch.setattr(upscaler._network, "_call_fn", watched)
    assert upscaler(torch.rand(2, 3, 9, 21)).shape == (2, 3, 18, 42)
    assert seen == [(1, 3, 24, 24)] * 2


def test_large_pictures_go_through_in_tiles(saved: Callable[..., Path]) -> None:
    upscaler = Foreign(saved(compact(2)))
    assert upscaler.reach_px is None
    pixels = np.random.default_rng(1).integers(0, 65535, (40, 70, 3), np.uint16)
    whole, tiled = enlarge(upscaler, pixels), enlarge(upscaler, pixels, tile_px=16)
    assert np.abs(whole.astype(int) - tiled).max() <= 1


@pytest.mark.parametrize("name", ["evil.pth", "evil.pt"])
def test_nothing_that_a_pickle_names_is_called(
    saved: Callable[..., Path], tmp_path: Path, name: str
) -> None:
    class Evil:
        def __reduce__(self) -> tuple[object, tuple[Path]]:
            return Path.touch, (tmp_path / "was here",)

    zipped = saved({**compact(2), "evil": Evil()}, name)
    with pytest.raises(InputError, match=r"holds more than numbers, .* as \.safetensors"):
        Foreign(zipped)
    zipped.write_bytes(pickle.dumps(Evil()))  # as before zip files
    with pytest.raises(InputError, match="holds more than numbers"):
        Foreign(zipped)
    assert not (tmp_path / "was here").exists()
    pickle.loads(pickle.dumps(Evil()))  # it would have been
    assert (tmp_path / "was here").exists()


@pytest.mark.parametrize(
    ("state", "name", "message"),
    [
        ({"a": torch.zeros(3)}, "w.pth", r"no network that spandrel knows"),
        ([1, 2], "w.pth", r"w\.pth holds no whole network"),
        (
            {"body.0.weight": torch.zeros(8, 3, 3, 3), "body.1.weight": torch.zeros(8)},
            "w.pth",
            "no ",
        ),
        (
            compact(2, channels=1),
            "w.pth",
            r"\(RealESRGAN Compact, SR\) makes 1 channels of 1; wanted",
        ),
    ],
    ids=["strange", "list", "half", "grey"],
)
def test_what_is_no_network_of_colours_is_refused(
    saved: Callable[..., Path], state: object, name: str, message: str
) -> None:
    with pytest.raises(InputError, match=message) as caught:
        Foreign(saved(state, name))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("own", "asked", "message"),
    [(2, 4, "scale=4: wanted 2, which is the network's"), (1, 17, "scale=17: wanted 1 to 16")],
)
def test_another_scale_is_refused(
    saved: Callable[..., Path], own: int, asked: int, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        Foreign(saved(compact(own)), scale=asked)


@pytest.mark.parametrize("name", ["cut.pth", "cut.safetensors"])
def test_a_file_cut_short_is_named(saved: Callable[..., Path], name: str) -> None:
    path = saved(compact(2), name)
    path.write_bytes(path.read_bytes()[:500])
    with pytest.raises(InputError, match=rf"{name} (is broken|cannot be read)"):
        Foreign(path)


def test_a_missing_file_is_named(spandrel: object) -> None:
    with pytest.raises(InputError, match=r"nowhere\.pth is missing: give a \.pth"):
        Foreign("nowhere.pth")


def test_restorers_of_faces_want_one(
    saved: Callable[..., Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    upscaler = Foreign(saved(compact(1)), scale=16)
    monkeypatch.setattr(upscaler._network, "_purpose", "FaceSR")
    with pytest.raises(InputError, match=r"restores faces of 512x512 px.* got 640x512 px after"):
        upscaler(torch.rand(1, 3, 32, 40))
    assert upscaler(torch.rand(1, 3, 32, 32)).shape == (1, 3, 512, 512)


def test_what_fills_holes_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    network = SimpleNamespace(
        purpose="Inpainting",
        input_channels=4,
        output_channels=3,
        architecture=SimpleNamespace(name="LaMa"),
    )
    library = SimpleNamespace(
        MAIN_REGISTRY=SimpleNamespace(copy=lambda: None),
        ModelLoader=lambda registry: SimpleNamespace(load_from_state_dict=lambda _: network),
        UnsupportedModelError=ZeroDivisionError,
    )
    monkeypatch.setattr(foreign, "find_spec", lambda name: name == "spandrel" or None)
    monkeypatch.setattr(foreign, "_library", lambda: library)
    torch.save({}, tmp_path / "lama.pth")
    with pytest.raises(InputError, match=r"\(LaMa, Inpainting\) makes 3 channels of 4 and a mask"):
        Foreign(tmp_path / "lama.pth")


def test_without_spandrel_the_remedy_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(foreign, "find_spec", lambda name: None)
    save_file(compact(2), tmp_path / "theirs.safetensors")
    for load in (Foreign, load_upscaler):
        with pytest.raises(InputError, match=r"spandrel.* is missing; pip install 'lrsr\[sr\]'"):
            load(tmp_path / "theirs.safetensors")
