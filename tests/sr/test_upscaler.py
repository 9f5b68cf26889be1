from collections.abc import Callable
from pathlib import Path

import numpy as np
import onnx
import pytest
import torch
from hydra.utils import instantiate
from omegaconf import OmegaConf

from lrsr.errors import ImageContractError, InputError
from lrsr.images import luminance, resize_bicubic, rgb_to_ycbcr, ycbcr_to_rgb
from lrsr.onnx import contract_path, sha256_of
from lrsr.paths import asset, config_folder
from lrsr.presets import preset
from lrsr.sr import Bicubic, Onnx, Upscaler, load_upscaler, onnx_network
from lrsr.sr.networks.edsr import EDSR
from lrsr.sr.networks.srcnn import SRCNN
from lrsr.sr.upscaler import Luminance, Repeated, Rgb
from lrsr.sr.weights import ENLARGED_BY, Card, read_weights

METHODS = (
    *("base", "bicubic2", "bicubic3", "bicubic4"),
    *("srcnn2", "srcnn2x2", "srcnn4", "srcnn2_camera", "srcnn4_camera"),
    *("fsrcnn2_camera", "fsrcnn4_camera", "imdn4_camera"),
)
OWN = {
    "srcnn3": ("srcnn", "SR 3"),
    **{f"srcnn955_{scale}": ("srcnn", f"SRCNN 9-5-5 {scale}") for scale in (2, 3, 4)},
    **{f"fsrcnn{scale}": ("fsrcnn", f"FSRCNN {scale}") for scale in (2, 3, 4)},
    **{f"edsr{scale}": ("edsr", f"EDSR {scale}") for scale in (2, 4)},
    **{f"imdn{scale}": ("imdn", f"IMDN {scale}") for scale in (2, 3, 4)},
    **{f"sparnet{scale}": ("sparnet", f"SPARNet {scale}") for scale in (2, 3, 4)},
}
"""Options that want weights of the user's own, their architectures and labels."""
SRCNN_CARD = Card("srcnn", {}, 2, "luminance", lr_made_by="test", enlarged_by=ENLARGED_BY)
EDSR_CARD = Card("edsr", {}, 2, "rgb", lr_made_by="test")


def built(method: str) -> Upscaler:
    """What ``conf/sr`` makes of a method's name."""
    upscaler: Upscaler = instantiate(OmegaConf.load(config_folder() / "sr" / f"{method}.yaml"))
    return upscaler


def srcnn_by_hand(srgb: torch.Tensor, scale: int) -> torch.Tensor:
    """SRCNN's way, written out: what every table of the project was made with."""
    network, _ = read_weights(asset(f"weights/srcnn{scale}x.safetensors"))
    ycbcr = rgb_to_ycbcr(resize_bicubic(srgb, scale))
    return ycbcr_to_rgb(torch.cat([network(ycbcr[:, :1]), ycbcr[:, 1:]], dim=1)).clamp(0, 1)


@pytest.fixture
def faces() -> torch.Tensor:
    """Three random srgb images inside the gamut, so that nothing is clipped."""
    generator = torch.Generator().manual_seed(5)
    return 0.3 + 0.4 * torch.rand(3, 3, 10, 8, generator=generator)


@pytest.mark.parametrize(
    ("method", "label", "scale"),
    [
        ("base", "Base", 1),
        ("bicubic2", "Bicubic 2", 2),
        ("bicubic3", "Bicubic 3", 3),
        ("bicubic4", "Bicubic 4", 4),
        ("srcnn2", "SR 2", 2),
        ("srcnn2x2", "SR 2x2", 4),
        ("srcnn4", "SR 4", 4),
        ("srcnn2_camera", "SR 2 camera", 2),
        ("srcnn4_camera", "SR 4 camera", 4),
        ("fsrcnn2_camera", "FSRCNN 2 camera", 2),
        ("fsrcnn4_camera", "FSRCNN 4 camera", 4),
        ("imdn4_camera", "IMDN 4 camera", 4),
    ],
)
def test_method_has_its_label_and_scale(
    faces: torch.Tensor, method: str, label: str, scale: int
) -> None:
    upscaler = built(method)
    assert (upscaler.label, upscaler.scale) == (label, scale)
    assert upscaler(faces).shape == (3, 3, 10 * scale, 8 * scale)


def test_every_option_is_tested() -> None:
    names = {path.stem for path in (config_folder() / "sr").glob("*.yaml")}
    assert names == {*METHODS, *OWN, "onnx", "foreign"}


@pytest.mark.parametrize("option", OWN)
def test_an_option_takes_weights_of_the_users_own(
    option: str, network_file: Callable[..., Path], faces: torch.Tensor
) -> None:
    (architecture, label), scale = OWN[option], int(option[-1])
    config = OmegaConf.load(config_folder() / "sr" / f"{option}.yaml")
    assert OmegaConf.is_missing(config, "weights")
    config.weights = str(network_file(architecture, scale))
    upscaler = instantiate(config)
    assert (upscaler.label, upscaler.scale, upscaler.learned) == (label, scale, True)
    assert upscaler(faces).shape == (3, 3, 10 * scale, 8 * scale)
    assert upscaler.describe()["architecture"] == architecture


@pytest.mark.parametrize("method", METHODS)
def test_what_learned_must_beat_the_bicubic_of_its_scale(method: str) -> None:
    assert built(method).learned is not method.startswith(("base", "bicubic"))


@pytest.mark.parametrize(("method", "scale"), [("srcnn2", 2), ("srcnn4", 4)])
def test_srcnns_pixels_are_those_of_the_way_written_out(
    faces: torch.Tensor, method: str, scale: int
) -> None:
    assert torch.equal(built(method)(faces), srcnn_by_hand(faces, scale))


def test_srcnn_2x2s_pixels_are_those_of_the_way_written_out(faces: torch.Tensor) -> None:
    assert torch.equal(built("srcnn2x2")(faces), srcnn_by_hand(srcnn_by_hand(faces, 2), 2))


def test_srcnn_restores_the_luminance_and_leaves_the_chroma_bicubic(
    faces: torch.Tensor, weights_file: Callable[..., Path]
) -> None:
    path = weights_file(2)
    network, _ = read_weights(path)
    larger = load_upscaler(path)(faces)
    bicubic = resize_bicubic(faces, 2)
    torch.testing.assert_close(luminance(larger), network(luminance(bicubic)), rtol=0, atol=2e-6)
    torch.testing.assert_close(
        rgb_to_ycbcr(larger)[:, 1:], rgb_to_ycbcr(bicubic)[:, 1:], rtol=0, atol=2e-6
    )


def test_a_network_of_luminance_that_enlarges_sees_the_small_picture(
    faces: torch.Tensor, network_file: Callable[..., Path]
) -> None:
    path = network_file("fsrcnn", 3, initialisation="near-bicubic")
    network, card = read_weights(path)
    larger, bicubic = load_upscaler(path)(faces), resize_bicubic(faces, 3)
    assert (card.input, card.enlarged_by) == ("luminance", "")
    torch.testing.assert_close(luminance(larger), network(luminance(faces)), rtol=0, atol=2e-6)
    torch.testing.assert_close(
        rgb_to_ycbcr(larger)[:, 1:], rgb_to_ycbcr(bicubic)[:, 1:], rtol=0, atol=2e-6
    )
    assert load_upscaler(path).describe()["kernel"] == ENLARGED_BY


def test_a_network_of_colours_sees_the_small_picture(
    faces: torch.Tensor, edsr_file: Callable[..., Path]
) -> None:
    network, _ = read_weights(edsr_file(4))
    assert torch.equal(load_upscaler(edsr_file(4))(faces), network(faces).clamp(0, 1))


def test_bicubic_is_the_one_bicubic(faces: torch.Tensor) -> None:
    torch.testing.assert_close(Bicubic(4)(faces), resize_bicubic(faces, 4).clamp(0, 1))


@pytest.mark.parametrize("kind", [np.int64, np.uint8])
def test_a_scale_may_be_of_any_width(faces: torch.Tensor, kind: type) -> None:
    twice = Repeated(Bicubic(kind(2)), kind(2))
    assert torch.equal(twice(faces), Repeated(Bicubic(2), 2)(faces))
    assert type(twice.scale) is int


def test_base_returns_the_image_itself(faces: torch.Tensor) -> None:
    assert torch.equal(Bicubic(1)(faces), faces)


def test_2x2_is_2x_taken_twice(faces: torch.Tensor, weights_file: Callable[..., Path]) -> None:
    path = weights_file(2)
    twice, once = load_upscaler(path, repeat=2), load_upscaler(path)
    torch.testing.assert_close(twice(faces), once(once(faces)), rtol=0, atol=0)
    assert twice.scale == 4


def test_batches_change_nothing(faces: torch.Tensor, weights_file: Callable[..., Path]) -> None:
    for upscaler in (Bicubic(4), load_upscaler(weights_file(2))):
        together = upscaler(faces)
        upscaler.batch_size = 1
        torch.testing.assert_close(upscaler(faces), together, rtol=0, atol=1e-6)


@pytest.mark.parametrize("method", METHODS)
def test_grey_stays_grey_without_colour(method: str) -> None:
    grey = torch.full((1, 3, 8, 8), 0.5)
    larger = built(method)(grey)
    seen = 1e-6 if method != "imdn4_camera" else 0.5 / 255  # which restores colours, too
    np.testing.assert_allclose((larger - larger[:, :1]).numpy(), 0.0, atol=seen)


@pytest.mark.parametrize("method", METHODS)
def test_result_is_clipped_to_0_and_1(method: str) -> None:
    edge = torch.full((1, 3, 8, 8), -9e-6)
    edge[..., 4:] = 1.0
    larger = built(method)(edge)
    assert float(larger.min()) >= 0.0
    assert float(larger.max()) <= 1.0


def test_one_pixel_can_be_enlarged() -> None:
    assert built("srcnn4")(torch.rand(1, 3, 1, 1)).shape == (1, 3, 4, 4)


@pytest.mark.parametrize("method", METHODS)
def test_no_gradient_is_kept(faces: torch.Tensor, method: str) -> None:
    plain = built(method)(faces)
    larger = built(method)(faces.clone().requires_grad_())
    assert not larger.requires_grad
    assert torch.equal(larger, plain)


def test_ycbcr_goes_there_and_back(faces: torch.Tensor) -> None:
    torch.testing.assert_close(ycbcr_to_rgb(rgb_to_ycbcr(faces)), faces, rtol=0, atol=1e-6)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    ("broken", "message"),
    [
        (lambda srgb: srgb[:, :1], r"srgb: got shape \(3, 1, 10, 8\)"),
        (lambda srgb: srgb * 255, r"srgb: got values .*wanted \[0, 1\]"),
        (lambda srgb: srgb * 2 - 1, r"srgb: got values -0\..*wanted \[0, 1\]"),
        (lambda srgb: srgb.bfloat16(), r"got torch.bfloat16, wanted torch.float32"),
        (lambda srgb: srgb.double(), r"got torch.float64, wanted torch.float32"),
        (lambda srgb: srgb.numpy(), r"got ndarray, wanted a torch\.Tensor"),
        (lambda srgb: srgb.tolist(), r"got list, wanted a torch\.Tensor"),
    ],
    ids=["grey", "0..255", "-1..1", "bfloat16", "float64", "numpy", "list"],
)
def test_pictures_of_another_kind_are_refused(
    faces: torch.Tensor, method: str, broken: Callable[[torch.Tensor], object], message: str
) -> None:
    with pytest.raises(ImageContractError, match=message):
        built(method)(broken(faces))


# what a report says


def test_a_learned_method_says_where_it_comes_from(weights_file: Callable[..., Path]) -> None:
    path = weights_file(2)
    assert load_upscaler(path, "Mine").describe() == {
        "label": "Mine",
        "scale": 2,
        "kind": "luminance",
        "file": path.name,
        "sha256": sha256_of(path),
        "architecture": "srcnn",
        "lr_made_by": "test",
        "kernel": ENLARGED_BY,
    }


def test_a_repeated_method_says_how_often(weights_file: Callable[..., Path]) -> None:
    told = load_upscaler(weights_file(2), "Mine", repeat=3).describe()
    assert (told["label"], told["scale"], told["times"]) == ("Mine", 8, 3)
    assert told["architecture"] == "srcnn"


@pytest.mark.parametrize(("scale", "kernel"), [(1, ""), (2, ENLARGED_BY)])
def test_bicubic_says_which(scale: int, kernel: str) -> None:
    assert Bicubic(scale).describe()["kernel"] == kernel


def test_labels_say_something_where_none_is_given(weights_file: Callable[..., Path]) -> None:
    assert (Bicubic(1).label, Bicubic(3).label) == ("Base", "Bicubic 3")
    assert Luminance(SRCNN(padding="replicate"), SRCNN_CARD).label == "srcnn 2"
    assert load_upscaler(weights_file(4)).label == "srcnn4x"
    assert Repeated(Bicubic(2), 2).label == "Bicubic 2, 2 times"


# files


def test_a_name_that_leads_nowhere_is_looked_for_among_those_that_ship(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, weights_file: Callable[..., Path]
) -> None:
    monkeypatch.chdir(tmp_path)
    name = "weights/srcnn2x.safetensors"
    assert load_upscaler(Path(name)).describe()["sha256"] == sha256_of(asset(name))
    (tmp_path / "weights").mkdir()
    own = weights_file(2).rename(tmp_path / name)
    assert load_upscaler(Path(name)).describe()["sha256"] == sha256_of(own)


def test_home_is_understood(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, weights_file: Callable[..., Path]
) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    assert load_upscaler(Path("~") / weights_file(2).name).scale == 2


def test_missing_weights_are_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"nowhere.safetensors is missing: give a .safetensors"):
        load_upscaler(tmp_path / "nowhere.safetensors")
    with pytest.raises(InputError, match=r"nowhere.onnx is missing"):
        load_upscaler(tmp_path / "nowhere.onnx")


@pytest.mark.parametrize("name", ["w.bin", "w", "None"])
def test_files_of_another_kind_are_refused(name: str) -> None:
    with pytest.raises(InputError, match=r"wanted a .safetensors, .ckpt, .onnx or .pth file"):
        load_upscaler(Path(name))


@pytest.mark.parametrize("repeat", [0, -1, 1.5, "2"])
def test_an_odd_repeat_is_refused(weights_file: Callable[..., Path], repeat: int) -> None:
    with pytest.raises(InputError, match=r"repeat=.*: wanted a whole number above 0"):
        load_upscaler(weights_file(2), repeat=repeat)


@pytest.mark.parametrize("scale", [0, -2, 2.5, 17, True])
def test_an_odd_scale_is_refused(scale: int) -> None:
    with pytest.raises(InputError, match=r"scale=.*: wanted a whole number from 1 to 16"):
        Bicubic(scale)


def test_a_network_in_the_wrong_wrapper_is_refused() -> None:
    with pytest.raises(InputError, match="srcnn takes luminance"):
        Rgb(SRCNN(), SRCNN_CARD)
    with pytest.raises(InputError, match="edsr takes rgb"):
        Luminance(EDSR(), EDSR_CARD)


@pytest.mark.parametrize("device", ["gpu", "cuda:99", "mars"])
def test_a_device_that_is_not_there_is_refused(device: str) -> None:
    with pytest.raises(InputError, match=f"device={device}: torch cannot use it") as caught:
        Bicubic(2, device=device)
    assert "\n" not in str(caught.value)


# networks that do not keep their word


def test_a_network_that_returns_nan_is_caught(faces: torch.Tensor) -> None:
    network = EDSR(blocks=1, features=4)
    with torch.no_grad():
        network.tail.bias.fill_(float("nan"))
    with pytest.raises(InputError, match=r"edsr 2 makes no numbers .*nan in image 0.*give other"):
        Rgb(network, EDSR_CARD)(faces)


def test_a_network_of_luminance_that_returns_nan_is_caught(faces: torch.Tensor) -> None:
    network = SRCNN(padding="replicate")
    with torch.no_grad():
        network.map.bias.fill_(float("nan"))
    with pytest.raises(InputError, match=r"srcnn 2 makes no numbers .*give other weights"):
        Luminance(network, SRCNN_CARD)(faces)


def test_a_network_of_another_scale_is_caught(faces: torch.Tensor) -> None:
    network = EDSR(scale=4, blocks=1, features=4)
    with pytest.raises(ImageContractError, match=r"got \(40, 32\) pixels of \(10, 8\), wanted"):
        Rgb(network, EDSR_CARD)(faces)


# somebody's ONNX


def nearest(srgb: torch.Tensor, gain: tuple[float, ...], scale: int = 2) -> torch.Tensor:
    larger = srgb.repeat_interleave(scale, 2).repeat_interleave(scale, 3)
    return larger * torch.tensor(gain)[:, None, None]


@pytest.mark.parametrize("span", ["0..1", "0..255"])
@pytest.mark.parametrize("layout", ["NCHW", "NHWC"])
@pytest.mark.parametrize(
    ("channels", "gain"), [("RGB", (1.0, 0.5, 0.25)), ("BGR", (0.25, 0.5, 1.0))]
)
def test_somebodys_network_sees_what_its_contract_says(
    somebodys: Callable[..., Path],
    faces: torch.Tensor,
    channels: str,
    gain: tuple[float, ...],
    layout: str,
    span: str,
) -> None:
    upscaler = load_upscaler(somebodys(channels=channels, layout=layout, range=span))
    torch.testing.assert_close(upscaler(faces), nearest(faces, gain), rtol=0, atol=1e-6)
    assert (upscaler.label, upscaler.scale, upscaler.learned) == ("theirs", 2, True)


def test_values_reach_somebodys_network_in_its_own_range(
    somebodys: Callable[..., Path], faces: torch.Tensor, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[np.ndarray] = []
    monkeypatch.setattr(
        "lrsr.sr.onnx_network.run_session",
        lambda session, model, values, batch_size: (
            seen.append(values) or values.repeat(2, 2).repeat(2, 3)
        ),
    )
    load_upscaler(somebodys(channels="BGR", range="0..255"))(faces)
    np.testing.assert_allclose(seen[0], faces.flip(1).numpy() * 255, rtol=1e-6)


def test_somebodys_network_of_luminance_leaves_the_chroma_bicubic(
    somebodys: Callable[..., Path], faces: torch.Tensor
) -> None:
    larger = load_upscaler(somebodys(channels="Y"))(faces)
    bright = luminance(faces).repeat_interleave(2, 2).repeat_interleave(2, 3)
    wanted = torch.cat([bright, rgb_to_ycbcr(resize_bicubic(faces, 2))[:, 1:]], dim=1)
    torch.testing.assert_close(larger, ycbcr_to_rgb(wanted).clamp(0, 1), rtol=0, atol=2e-6)


def test_somebodys_network_may_want_the_picture_enlarged(
    somebodys: Callable[..., Path], faces: torch.Tensor
) -> None:
    upscaler = load_upscaler(somebodys(enlarged=True, scale=4, grows=1))
    wanted = resize_bicubic(faces, 4) * torch.tensor([1.0, 0.5, 0.25])[:, None, None]
    torch.testing.assert_close(upscaler(faces), wanted, rtol=0, atol=1e-6)
    assert upscaler.describe()["kernel"] == ENLARGED_BY


@pytest.mark.parametrize("size", [(4, 6), (16, 16), ("H", 5)], ids=str)
@pytest.mark.parametrize("batch", ["N", 1, 2], ids=["free", "one", "two"])
def test_a_fixed_size_or_batch_is_met_by_tiles(
    somebodys: Callable[..., Path],
    faces: torch.Tensor,
    size: tuple[int | str, int | str],
    batch: int | str,
) -> None:
    upscaler = load_upscaler(somebodys(size=size, batch=batch))
    wanted = nearest(faces, (1.0, 0.5, 0.25))
    torch.testing.assert_close(upscaler(faces), wanted, rtol=0, atol=1e-6)


def test_a_multiple_is_met_by_filling_up(
    somebodys: Callable[..., Path], faces: torch.Tensor, monkeypatch: pytest.MonkeyPatch
) -> None:
    upscaler = Onnx(somebodys(multiple_of=8))
    seen: list[tuple[int, ...]] = []
    run = upscaler._run
    monkeypatch.setattr(upscaler, "_run", lambda images: seen.append(images.shape) or run(images))
    torch.testing.assert_close(upscaler(faces), nearest(faces, (1.0, 0.5, 0.25)))
    assert seen == [(3, 3, 16, 8)]


def test_somebodys_network_says_where_it_comes_from(somebodys: Callable[..., Path]) -> None:
    told = load_upscaler(somebodys(), "Theirs").describe()
    assert (told["kind"], told["file"], told["architecture"]) == ("onnx", "theirs.onnx", "a test")
    assert (told["label"], told["kernel"]) == ("Theirs", "")


@pytest.mark.parametrize("white", [255.0, float("nan")], ids=["of another range", "no number"])
def test_values_that_are_no_picture_are_refused(
    somebodys: Callable[..., Path],
    faces: torch.Tensor,
    white: float,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    run = onnx_network.run_session
    bright = lambda *given, **more: run(*given, **more) * white  # noqa: E731
    monkeypatch.setattr(onnx_network, "run_session", bright)
    wish = r"theirs\.onnx: returned values to (\d\d\d.*|nan), its contract says 0\.\.1; mend"
    with pytest.raises(InputError, match=wish):
        load_upscaler(somebodys())(faces)


def test_a_contract_of_another_scale_is_caught(
    somebodys: Callable[..., Path], faces: torch.Tensor
) -> None:
    with pytest.raises(InputError, match=r"got \(20, 16\) pixels of \(10, 8\), wanted"):
        load_upscaler(somebodys(scale=4))(faces)


@pytest.mark.parametrize(
    "wrong", [{"layout": "NHWC"}, {"channels": "Y"}], ids=["layout", "channels"]
)
def test_a_graph_that_disagrees_with_its_contract_is_refused(
    somebodys: Callable[..., Path], wrong: dict[str, str]
) -> None:
    path = somebodys()
    text = contract_path(path).read_text()
    for name, value in wrong.items():
        text = text.replace("'NCHW'" if name == "layout" else "'RGB'", f"'{value}'")
    contract_path(path).write_text(text)
    with pytest.raises(InputError, match=r"theirs\.onnx: takes .*, its contract says float"):
        load_upscaler(path)


def test_a_card_in_an_onnx_file_is_enough(
    somebodys: Callable[..., Path], faces: torch.Tensor
) -> None:
    path = somebodys(channels="Y", grows=1)
    contract_path(path).unlink()
    model = onnx.load(path)
    onnx.helper.set_model_props(model, SRCNN_CARD.as_text())
    onnx.save(model, path)
    upscaler = load_upscaler(path)
    torch.testing.assert_close(upscaler(faces), resize_bicubic(faces, 2), rtol=0, atol=2e-6)
    told = upscaler.describe()
    assert (told["kind"], told["architecture"], told["kernel"]) == ("onnx", "srcnn", ENLARGED_BY)


def test_an_onnx_network_is_an_option_with_a_typed_contract(
    somebodys: Callable[..., Path], faces: torch.Tensor
) -> None:
    """``lrsr upscale sr=onnx``, and ``lrsr eval methods=[base,onnx] sr.onnx.model=FILE``."""
    model = somebodys(reach_px=9)
    told = preset("sr", "onnx", model=str(model))
    assert (told.label, told.scale, told.reach_px) == ("theirs", 2, 9)
    contract_path(model).unlink()
    typed = preset("sr", "onnx", model=str(model), contract={"scale": 2, "channels": "RGB"})
    assert torch.equal(typed(faces), told(faces))


def test_fixed_tiles_reach_a_quarter_of_a_tile(somebodys: Callable[..., Path]) -> None:
    assert load_upscaler(somebodys(size=(8, 12))).reach_px == 3
