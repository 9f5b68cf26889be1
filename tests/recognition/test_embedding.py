import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import onnx
import onnxruntime
import pytest
import torch
from fakes.contracts import declare

from lrsr.errors import ImageContractError, InputError
from lrsr.onnx import contract_path, run_session, sha256_of
from lrsr.recognition import embedding
from lrsr.recognition.embedding import Embedder, _unit_rows

WriteModel = Callable[..., Path]
DATA = Path(__file__).parents[1] / "data"


def colours(*rgb: tuple[float, float, float], side: int = 112) -> torch.Tensor:
    return torch.tensor(rgb)[:, :, None, None].expand(-1, 3, side, side).contiguous()


def declare_new_bytes(model: Path, old: str) -> None:
    path = contract_path(model)
    path.write_text(path.read_text().replace(old, sha256_of(model)))


@pytest.mark.parametrize(
    ("declared", "expected"),
    [
        ({}, [1.0, 0.0, -1.0]),  # (255 srgb - 127.5) / 127.5
        ({"layout": "NHWC"}, [1.0, 0.0, -1.0]),
        ({"channels": "BGR"}, [-1.0, 0.0, 1.0]),
        ({"mean": 0.0, "scale": 255.0}, [1.0, 0.5, 0.0]),
        ({"mean": (255.0, 0.0, 1.0), "scale": (1.0, 127.5, 0.5)}, [0.0, 1.0, -2.0]),
        (
            {"channels": "BGR", "mean": (0.0, 0.0, 255.0), "scale": (1.0, 127.5, 1.0)},
            [0.0, 1.0, 0.0],  # blue, green, red
        ),
        (
            {"layout": "NHWC", "channels": "BGR", "mean": 0.0, "scale": 255.0},
            [0.0, 0.5, 1.0],
        ),
        ({"side": 64, "height_px": 64, "width_px": 64}, [1.0, 0.0, -1.0]),
    ],
    ids=["arcface", "nhwc", "bgr", "zero-to-one", "three", "three-bgr", "deepface", "size"],
)
def test_the_model_sees_what_its_contract_says(
    write_model: WriteModel, declared: dict[str, object], expected: list[float]
) -> None:
    side = int(declared.get("side", 112))  # type: ignore[call-overload]
    embedding = Embedder(write_model(**declared))(colours((1.0, 0.5, 0.0), side=side))
    wanted = np.array([expected + [2 * value for value in expected]])
    np.testing.assert_allclose(embedding, wanted / np.linalg.norm(wanted), atol=1e-6)


@pytest.mark.parametrize("batch", ["batch", 1, 2], ids=["free", "one", "two"])
def test_batches_change_nothing(write_model: WriteModel, batch: int | str) -> None:
    crops = torch.rand(4, 3, 112, 112, generator=torch.Generator().manual_seed(0))
    embedder = Embedder(write_model(batch=batch), batch_size=3)
    reference = Embedder(write_model())(crops)
    np.testing.assert_allclose(embedder(crops), reference, atol=1e-6)


def test_a_fixed_batch_is_filled_up(write_model: WriteModel) -> None:
    crops = torch.rand(3, 3, 112, 112, generator=torch.Generator().manual_seed(0))
    assert Embedder(write_model(batch=2))(crops).shape == (3, 6)


def test_embeddings_have_length_one(tiny_model: Path) -> None:
    crops = torch.rand(3, 3, 112, 112, generator=torch.Generator().manual_seed(0))
    np.testing.assert_allclose(np.linalg.norm(Embedder(tiny_model)(crops), axis=1), 1, atol=1e-6)


def test_no_faces_give_no_embeddings(tiny_model: Path) -> None:
    assert Embedder(tiny_model)(torch.empty(0, 3, 112, 112)).shape == (0, 6)


def test_a_row_of_zeros_stays_zero() -> None:
    assert _unit_rows(np.zeros((1, 3), dtype=np.float32)).tolist() == [[0, 0, 0]]


def test_broken_crops_are_refused(tiny_model: Path) -> None:
    with pytest.raises(ImageContractError, match=r"crops: got shape"):
        Embedder(tiny_model)(torch.zeros(1, 1, 112, 112))


@pytest.mark.parametrize(
    ("made", "message"),
    [
        ({"layout": "NCHW", "dimension": 512}, r"its contract says dimension 512"),
        ({"side": 96}, r"takes tensor\(float\) .*96.*its contract says float NCHW \(3, 112, 112\)"),
    ],
    ids=["dimension", "size"],
)
def test_a_graph_that_disagrees_with_its_contract_is_refused(
    write_model: WriteModel, made: dict[str, object], message: str
) -> None:
    with pytest.raises(InputError, match=message) as caught:
        Embedder(write_model(**made))
    assert "\n" not in str(caught.value)


def test_a_graph_of_another_layout_is_refused(tiny_model: Path) -> None:
    path = contract_path(tiny_model)
    path.write_text(path.read_text().replace('"NCHW"', '"NHWC"'))
    with pytest.raises(InputError, match=r"its contract says float NHWC \(112, 112, 3\)"):
        Embedder(tiny_model)


@pytest.fixture
def two_outputs(tiny_model: Path) -> Path:
    """Let the model return the means, too, and before its embeddings."""
    old = sha256_of(tiny_model)
    model = onnx.load(tiny_model)
    means = onnx.helper.make_tensor_value_info("means", onnx.TensorProto.FLOAT, ["batch", 3])
    model.graph.output.insert(0, means)
    onnx.save(model, tiny_model)
    declare_new_bytes(tiny_model, old)
    return tiny_model


def name_the_output(model: Path, name: str) -> None:
    path = contract_path(model)
    path.write_text(path.read_text().replace("dimension = 6", f'dimension = 6\nname = "{name}"'))


def test_of_several_outputs_the_named_one_is_taken(two_outputs: Path) -> None:
    name_the_output(two_outputs, "embeddings")
    assert Embedder(two_outputs)(colours((1.0, 0.5, 0.0))).shape == (1, 6)


def test_an_output_that_is_not_there_is_named(two_outputs: Path) -> None:
    name_the_output(two_outputs, "features")
    with pytest.raises(InputError, match="has no output 'features'; it has means, embeddings"):
        Embedder(two_outputs)


def test_a_face_reaches_the_model_as_insightface_feeds_it(tmp_path: Path) -> None:
    oracle = json.loads((DATA / "insightface_arcface_onnx.json").read_text())
    bgr = np.random.default_rng(0).integers(0, 256, (112, 112, 3), dtype=np.uint8)
    crops = torch.from_numpy(bgr[..., ::-1].copy()).permute(2, 0, 1)[None].float() / 255
    embedder = Embedder(write_pooling_model(tmp_path / "pool.onnx"))
    expected = np.array(oracle["embedding"])
    inputs = embedder._normalise(crops)
    found = run_session(embedder._session, embedder.model, inputs, batch_size=1)[0]
    np.testing.assert_allclose(found, expected, atol=1e-5)
    np.testing.assert_allclose(embedder(crops)[0], expected / np.linalg.norm(expected), atol=1e-5)


def write_pooling_model(path: Path) -> Path:
    """Write the graph that the oracle was run with, see the JSON's source."""
    kind, shape = onnx.TensorProto.FLOAT, ["N", 3, 112, 112]
    graph = onnx.helper.make_graph(
        [
            onnx.helper.make_node(
                "AveragePool", ["data"], ["pooled"], kernel_shape=[16, 16], strides=[16, 16]
            ),
            onnx.helper.make_node("Flatten", ["pooled"], ["embedding"]),
        ],
        "pool",
        [onnx.helper.make_tensor_value_info("data", kind, shape)],
        [onnx.helper.make_tensor_value_info("embedding", kind, ["N", 147])],
    )
    opset = [onnx.helper.make_opsetid("", 18)]
    onnx.save(onnx.helper.make_model(graph, opset_imports=opset, ir_version=9), path)
    return declare(path, 147)


def test_a_detector_is_no_embedder(tiny_model: Path) -> None:
    old = sha256_of(tiny_model)
    model = onnx.load(tiny_model)
    model.graph.output.append(model.graph.output[0])
    model.graph.output[1].name = "twice"
    onnx.save(model, tiny_model)
    declare_new_bytes(tiny_model, old)
    with pytest.raises(InputError, match="1 inputs and 2 outputs; an embedder has one of each"):
        Embedder(tiny_model)


def test_a_file_that_is_no_onnx_is_refused(tiny_model: Path) -> None:
    old = sha256_of(tiny_model)
    tiny_model.write_bytes(b"not a model")
    declare_new_bytes(tiny_model, old)
    with pytest.raises(InputError, match=r"tiny\.onnx: not a usable ONNX model") as caught:
        Embedder(tiny_model)
    assert "\n" not in str(caught.value)


def test_cuda_is_used_where_onnxruntime_has_it(
    tiny_model: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[tuple[str, ...]] = []
    opened = embedding.open_session
    monkeypatch.setattr(
        embedding, "open_session", lambda model, who: asked.append(who) or opened(model)
    )
    monkeypatch.setattr(onnxruntime, "get_available_providers", lambda: ["CUDAExecutionProvider"])
    for device in ("cpu", "cuda"):
        Embedder(tiny_model, device=device)
    assert [who[0] for who in asked] == ["CPUExecutionProvider", "CUDAExecutionProvider"]


def test_a_network_that_returns_no_numbers_is_told_by_its_file(write_model: WriteModel) -> None:
    model = write_model(mean=0.0, scale=1e-38)  # 255 / 1e-38 is no float32
    with pytest.raises(InputError, match=r"tiny\.onnx: returned a NaN or an infinity for input 0"):
        Embedder(model)(colours((1.0, 0.5, 0.2)))
