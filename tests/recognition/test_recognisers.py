"""Which encoder is taken, with dlib and without."""

from pathlib import Path
from typing import get_args

import numpy as np
import pytest
import torch
from fakes.dlib_parts import install_dlib, remove_dlib

from lrsr.errors import InputError
from lrsr.recognition import Engine
from lrsr.recognition.alignment import TEMPLATE_PX
from lrsr.recognition.dlib_encoder import DlibEncoder
from lrsr.recognition.recognisers import (
    _ENCODERS,
    SMALLEST_ANGLE_DEG,
    _EncoderName,
    find_recognisers,
    load_encoder,
    load_recognisers,
    resolve_encoder,
)


@pytest.mark.parametrize(
    ("name", "resolved"), [("auto", "dlib"), ("dlib", "dlib"), ("shipped", "shipped")]
)
def test_with_dlib_it_is_taken_unless_the_shipped_one_is_asked_for(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, name: str, resolved: str
) -> None:
    install_dlib(monkeypatch, tmp_path)
    assert resolve_encoder(name) == resolved


@pytest.mark.parametrize("name", ["auto", "shipped"])
def test_without_dlib_the_shipped_one_is_taken(monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    remove_dlib(monkeypatch)
    assert resolve_encoder(name) == "shipped"


def test_dlib_asked_for_but_not_installed_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    remove_dlib(monkeypatch)
    with pytest.raises(InputError, match=r"pip install 'lrsr\[dlib\]', or give encoder=shipped"):
        resolve_encoder("dlib")


def test_an_unknown_encoder_is_refused_with_those_there_are() -> None:
    with pytest.raises(InputError, match="encoder=facenet: wanted one of auto, dlib, shipped"):
        resolve_encoder("facenet")


def test_every_encoder_has_a_smallest_angle() -> None:
    assert get_args(_EncoderName) == _ENCODERS
    assert set(SMALLEST_ANGLE_DEG) == set(_ENCODERS) - {"auto"}
    assert SMALLEST_ANGLE_DEG["dlib"] == 11.2  # the smallest of the paper


def test_the_shipped_encoder_embeds_with_rows_of_length_one() -> None:
    encoder = load_encoder("shipped")
    images = torch.rand(2, 3, 112, 112, generator=torch.Generator().manual_seed(0))
    rows = encoder.embed(images, np.stack([TEMPLATE_PX] * 2))
    np.testing.assert_allclose(np.linalg.norm(rows, axis=1), 1, atol=1e-5)


def test_a_given_model_stands_in_for_the_shipped_one(tiny_model: Path) -> None:
    encoder = load_encoder("shipped", tiny_model)
    assert isinstance(encoder, Engine)
    assert encoder.describe()["model"] == tiny_model.name


def test_dlib_is_loaded_when_it_is_asked_for(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    install_dlib(monkeypatch, tmp_path)
    assert isinstance(load_encoder("dlib"), DlibEncoder)


def test_dlib_takes_no_other_model(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, tiny_model: Path
) -> None:
    install_dlib(monkeypatch, tmp_path / "site")
    with pytest.raises(InputError, match=r"recognition\.model=.*tiny\.onnx: .*encoder=shipped"):
        load_encoder("dlib", tiny_model)


def test_a_missing_model_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"absent\.onnx"):
        load_encoder("shipped", tmp_path / "absent.onnx")


def test_recognisers_are_called_by_name_and_files_by_their_stem(tiny_model: Path) -> None:
    found = find_recognisers(["shipped", str(tiny_model)])
    assert found == {"shipped": "shipped", "tiny": tiny_model}
    loaded = load_recognisers(find_recognisers(["shipped", str(tiny_model)]))
    assert [one.describe()["model"] for one in loaded.values()] == [
        "arcface_small.onnx",
        "tiny.onnx",
    ]


def test_a_given_model_takes_the_shipped_ones_place_and_has_its_own_name(tiny_model: Path) -> None:
    assert find_recognisers(["shipped"], tiny_model) == {"tiny": tiny_model}


@pytest.mark.parametrize(
    ("names", "says"),
    [
        ([], r"recognition.recognisers=\[\]: wanted at least one"),
        (["shipped", "shipped"], "shipped is there twice"),
        (["shiped"], "no recogniser 'shiped'"),
        (["buffalo_l"], "buffalo_l is not here: lrsr models pull buffalo_l"),
        (["w600k_mbf"], "w600k_mbf is not here: lrsr models pull buffalo_s"),
        (["w600k_r51"], "did you mean w600k_r50"),
    ],
)
def test_names_that_are_nobodys_are_refused(names: list[str], says: str) -> None:
    with pytest.raises(InputError, match=says):
        find_recognisers(names)


def test_a_model_for_nobody_is_refused(tiny_model: Path) -> None:
    with pytest.raises(InputError, match=r"recognition\.model=.*tiny.onnx: add shipped"):
        find_recognisers([str(tiny_model)], tiny_model)


def test_dlib_that_is_not_installed_is_refused_before_anything_is_done(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    remove_dlib(monkeypatch)
    with pytest.raises(InputError, match="dlib: it or its models"):
        find_recognisers(["dlib"])


def test_dlib_recognises_as_any_other(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    install_dlib(monkeypatch, tmp_path)
    dlib = load_recognisers(find_recognisers(["dlib"]))["dlib"]
    faces = torch.rand(2, 3, 112, 112, generator=torch.Generator().manual_seed(0))
    rows = dlib.embed(faces, np.stack([TEMPLATE_PX] * 2))
    scores = dlib.compare(rows, rows, ["a", "b"], ["a", "b"])
    np.testing.assert_allclose(scores.mated_scores(), 1, atol=1e-6)


def test_models_of_dlib_that_were_pulled_are_found(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    dlib = install_dlib(monkeypatch, tmp_path / "site")
    models = tmp_path / "models"
    (tmp_path / "site" / "models").rename(models)
    with pytest.raises(InputError, match="not installed"):
        DlibEncoder()
    monkeypatch.setenv("LRSR_MODELS", str(models))
    DlibEncoder()
    assert len(dlib.loaded) == 2
