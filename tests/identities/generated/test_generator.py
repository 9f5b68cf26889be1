from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fakes.generators import write_generator

from lrsr.errors import InputError
from lrsr.identities.generated.generator import Generator

RNG = np.random.default_rng(3)
MATRIX = RNG.normal(0, 0.05, (3 * 4 * 5, 6))
BASE = RNG.uniform(0.3, 0.7, (3, 4, 5))
MAPPING = RNG.normal(0, 1, (6, 7))


def made(folder: Path, matrix: Any = MATRIX, base: Any = BASE, **how: Any) -> Generator:
    return Generator(write_generator(folder / "synthesis.onnx", matrix, base, **how))


@pytest.mark.parametrize("layout", ["NCHW", "NHWC"])
@pytest.mark.parametrize("channels", ["RGB", "BGR"])
@pytest.mark.parametrize(
    ("values", "black", "white"), [("0..1", 0, 1), ("-1..1", -1, 1), ("0..255", 0, 255)]
)
def test_pictures_are_what_the_contract_says(
    tmp_path: Path, layout: str, channels: str, values: str, black: float, white: float
) -> None:
    planes = BASE[::-1] if channels == "BGR" else BASE
    stored = planes.transpose(1, 2, 0) if layout == "NHWC" else planes
    base, nothing = stored * (white - black) + black, np.zeros((60, 6))
    generator = made(tmp_path, nothing, base, layout=layout, channels=channels, values=values)
    pictures = generator.pictures(np.zeros((2, 6), np.float32))
    assert pictures.shape == (2, 4, 5, 3)
    assert np.abs(pictures[1] - BASE.transpose(1, 2, 0) * 255).max() < 0.51


def test_what_is_beyond_black_and_white_is_clipped(tmp_path: Path) -> None:
    pictures = made(tmp_path, base=BASE * 4 - 1.5).pictures(np.zeros((1, 6), np.float32))
    assert (pictures.min(), pictures.max()) == (0, 255)


def test_people_are_normal_numbers_of_their_own_seed(tmp_path: Path) -> None:
    generator = made(tmp_path)
    both = generator.sample([(7, 1, 0), (7, 1, 1)])
    expected = np.random.default_rng((7, 1, 1)).standard_normal(6)
    assert both[1] == pytest.approx(expected, rel=1e-6)
    assert (generator.sample([(7, 1, 1)])[0] == both[1]).all()


@pytest.mark.parametrize("layers", [0, 3], ids=["w", "w+"])
def test_a_mapping_makes_w_of_z(tmp_path: Path, layers: int) -> None:
    generator = made(tmp_path, mapping=MAPPING, layers=layers)
    z = np.random.default_rng((0, 5)).standard_normal(7)
    w = generator.sample([(0, 5)])
    assert generator.size == 6
    assert w[0] == pytest.approx(MAPPING @ z + 1, rel=1e-5)
    wanted = np.clip(BASE + (MATRIX @ w[0]).reshape(3, 4, 5), 0, 1).transpose(1, 2, 0) * 255
    assert np.abs(generator.pictures(w)[0] - wanted).max() < 0.51


def test_truncation_goes_to_the_mean_w(tmp_path: Path) -> None:
    generator = made(tmp_path, mapping=MAPPING)
    drawn, half, mean = (generator.sample([(0, 5)], psi)[0] for psi in (1.0, 0.5, 0.0))
    assert half == pytest.approx((drawn + mean) / 2, abs=1e-5)
    off = np.linalg.norm(MAPPING, axis=1) / 100  # of the mean of 10,000
    assert (np.abs(mean - 1) < 4.5 * off).all()


@pytest.mark.parametrize(
    ("how", "says"),
    [
        ({"noisy": True}, 'noise_mode="const"'),
        ({"base": BASE * np.nan}, "returned a NaN or an infinity for input 0"),
        ({"values": "0..2"}, "output.range = '0..2'"),
    ],
    ids=["noise", "NaN", "range"],
)
def test_a_generator_that_cannot_be_used_is_refused(
    tmp_path: Path, how: dict[str, Any], says: str
) -> None:
    with pytest.raises(InputError, match=says):
        made(tmp_path, **how)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('mapping = "mapping.onnx"', "", "latent.w and latent.mapping go together"),
        ('mapping = "mapping.onnx"', 'mapping = "../mapping.onnx"', "wanted a file beside it"),
        ("w = 6", "w = 5", r"takes tensor\(float\) \['batch', 6\], its contract says \(N, 5\)"),
        ("z = 7", "z = 8", "its contract says z = 8"),
        ('mapping_sha256 = "', 'mapping_sha256 = "0', "latent.mapping_sha256 of"),
        ("z = 7", "z = 0", "latent.z = 0; wanted 1 to 65536"),
    ],
    ids=["w alone", "elsewhere", "w", "z", "sha256", "no z"],
)
def test_a_contract_that_says_something_else_is_refused(
    tmp_path: Path, old: str, new: str, says: str
) -> None:
    path = write_generator(tmp_path / "synthesis.onnx", MATRIX, BASE, mapping=MAPPING)
    contract = path.with_suffix(".toml")
    contract.write_text(contract.read_text().replace(old, new))
    with pytest.raises(InputError, match=says):
        Generator(path)


def test_layers_without_a_w_are_refused(tmp_path: Path) -> None:
    path = write_generator(tmp_path / "synthesis.onnx", MATRIX, BASE)
    contract = path.with_suffix(".toml")
    contract.write_text(contract.read_text().replace("z = 6", "z = 6\nlayers = 2"))
    with pytest.raises(InputError, match=r"latent\.layers = 2; wanted none without a w"):
        Generator(path)


def test_truncation_without_a_mapping_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"truncation=0\.7: wanted 1"):
        made(tmp_path).sample([(0,)], 0.7)


def test_latents_of_another_size_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"cannot take an input of \(7,\)"):
        made(tmp_path).pictures(np.zeros((1, 7), np.float32))


def test_rows_that_differ_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    generator = made(tmp_path, mapping=MAPPING, layers=3)
    rows = np.array([[[1.0, 2.0], [1.0, 2.5]]], np.float32)
    monkeypatch.setattr("lrsr.identities.generated.generator.run_session", lambda *_, **__: rows)
    with pytest.raises(InputError, match="another w for each layer"):
        generator.sample([(0,)])
