"""Opening, running and declaring ONNX files."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import onnx
import onnxruntime
import pytest
import torch
from onnx import TensorProto, helper

from lrsr.errors import InputError
from lrsr.onnx import (
    check_graph,
    contract_path,
    open_session,
    providers_on,
    read_declared,
    run_lists,
    run_session,
    sha256_of,
)

CPU = "CPUExecutionProvider"
TABLES = {"": ["sha256"], "input": ["mean", "multiple_of"]}


@dataclass
class Declared:
    sha256: str
    mean: float
    multiple_of: int = 1


@pytest.fixture
def write_doubler(tmp_path: Path) -> Callable[..., Path]:
    """Write one node that doubles what it gets."""

    def write(batch: int | str = "N", *, external: bool = False) -> Path:
        path = tmp_path / "double.onnx"
        two = onnx.numpy_helper.from_array(np.full((1, 300), 2.0, dtype=np.float32), "two")
        graph = helper.make_graph(
            [helper.make_node("Mul", ["x", "two"], ["y"])],
            "double",
            [helper.make_tensor_value_info("x", TensorProto.FLOAT, [batch, 300])],
            [helper.make_tensor_value_info("y", TensorProto.FLOAT, [batch, 300])],
            [two],
        )
        opset = [helper.make_opsetid("", 18)]
        model = helper.make_model(graph, opset_imports=opset, ir_version=9)
        onnx.save(model, path, save_as_external_data=external, location="double.bin")
        return path

    return write


def ramp(count: int) -> np.ndarray:
    return np.arange(count * 300, dtype=np.float32).reshape(count, 300)


@pytest.mark.parametrize("batch", ["N", 1, 2], ids=["free", "one", "two"])
@pytest.mark.parametrize("count", [1, 3, 5])
def test_a_batch_is_run_part_by_part_and_filled_up(
    write_doubler: Callable[..., Path], batch: int | str, count: int
) -> None:
    path = write_doubler(batch)
    result = run_session(open_session(path), path, ramp(count), batch_size=2)
    np.testing.assert_array_equal(result, 2 * ramp(count))


@pytest.mark.parametrize("batch", ["N", 1, 2], ids=["free", "one", "two"])
@pytest.mark.parametrize("count", [1, 3, 5])
def test_every_image_of_a_batch_has_its_list(
    write_doubler: Callable[..., Path], batch: int | str, count: int
) -> None:
    path = write_doubler(batch)
    (result,) = run_lists(open_session(path), path, ramp(count), ["y"], batch_size=2)
    np.testing.assert_array_equal(result, 2 * ramp(count)[:, None])


def test_what_is_no_list_for_each_image_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "sums.onnx"
    images = helper.make_tensor_value_info("x", TensorProto.FLOAT, ["N", 4])
    sums = helper.make_tensor_value_info("y", TensorProto.FLOAT, [])
    node = helper.make_node("ReduceSum", ["x"], ["y"], keepdims=0)
    graph = helper.make_graph([node], "sums", [images], [sums])
    opset = [helper.make_opsetid("", 18)]
    onnx.save(helper.make_model(graph, opset_imports=opset, ir_version=9), path)
    inputs = np.zeros((2, 4), dtype=np.float32)
    with pytest.raises(InputError, match=r"sums\.onnx: output y has shape \(\) for 2 images"):
        run_lists(open_session(path), path, inputs, ["y"], batch_size=2)


def test_a_session_runs_on_as_many_threads_as_torch(write_doubler: Callable[..., Path]) -> None:
    options = open_session(write_doubler()).get_session_options()
    assert options.intra_op_num_threads == torch.get_num_threads()


def test_an_input_of_another_size_is_the_users_to_mend(write_doubler: Callable[..., Path]) -> None:
    path = write_doubler()
    with pytest.raises(InputError, match=r"double\.onnx: cannot take an input of \(7,\)") as caught:
        run_session(open_session(path), path, np.zeros((1, 7), np.float32), batch_size=1)
    assert "\n" not in str(caught.value)


def test_external_data_beside_the_file_is_found(write_doubler: Callable[..., Path]) -> None:
    path = write_doubler(external=True)
    np.testing.assert_array_equal(
        run_session(open_session(path), path, ramp(1), batch_size=1), 2 * ramp(1)
    )


def test_missing_external_data_is_the_users_to_mend(
    write_doubler: Callable[..., Path], tmp_path: Path
) -> None:
    path = write_doubler(external=True)
    (tmp_path / "double.bin").unlink()
    with pytest.raises(InputError, match=r"double\.onnx: not a usable ONNX model") as caught:
        open_session(path)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "content", [b"", b"not a model", b"\x08\x07"], ids=["empty", "text", "cut"]
)
def test_a_file_that_is_no_onnx_is_refused(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "broken.onnx"
    path.write_bytes(content)
    with pytest.raises(InputError, match=r"broken\.onnx: not a usable ONNX model"):
        open_session(path)


def test_a_missing_file_and_a_folder_are_refused(tmp_path: Path) -> None:
    for path, what in ((tmp_path / "gone.onnx", "is missing"), (tmp_path, "is a folder")):
        with pytest.raises(InputError, match=f"{what}.*: give an ONNX file"):
            open_session(path)


def test_the_cpu_computes_unless_cuda_is_asked_for_and_there(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(onnxruntime, "get_available_providers", lambda: ["CUDAExecutionProvider"])
    assert providers_on("cpu") == (CPU,)
    for device in ("cuda", "auto"):
        assert providers_on(device) == ("CUDAExecutionProvider", CPU)
    assert not caplog.messages
    monkeypatch.setattr(onnxruntime, "get_available_providers", lambda: [CPU])
    assert providers_on("auto") == (CPU,)
    assert not caplog.messages
    assert providers_on("cuda:0") == (CPU,)
    assert "no CUDA" in caplog.text


@pytest.mark.parametrize(
    ("takes", "returns", "message"),
    [
        ((None, 7), (None, 300), r"takes tensor\(float\) .*300.*its contract says words in"),
        ((None, 300), (None, 7), r"returns tensor\(float\) .*300.*its contract says words out"),
        ((None, 300, 1), (None, 300), "takes"),
    ],
    ids=["input", "output", "rank"],
)
def test_a_graph_that_disagrees_is_refused(
    write_doubler: Callable[..., Path],
    takes: tuple[int | None, ...],
    returns: tuple[int | None, ...],
    message: str,
) -> None:
    path = write_doubler()
    with pytest.raises(InputError, match=message):
        check_graph(
            open_session(path), path, "a doubler", takes, returns, ("words in", "words out")
        )


def declare(model: Path, rest: str) -> Path:
    contract_path(model).write_text(f'sha256 = "{sha256_of(model)}"\n{rest}')
    return model


def test_fields_that_are_left_out_have_their_value(write_doubler: Callable[..., Path]) -> None:
    model = declare(write_doubler(), "[input]\nmean = 2\n")
    told = read_declared(Declared, model, TABLES, {})
    assert told == Declared(sha256_of(model), 2.0, 1)
    assert type(told.mean) is float


@pytest.mark.parametrize(
    ("rest", "message"),
    [
        ("[input]\n", r"input\.mean is missing; declare it"),
        ("[input]\nmean = nan\n", r"input\.mean = nan; wanted float"),
        ("[input]\nmean = 1\nmultiple_of = 2.0\n", r"multiple_of = 2\.0; wanted int"),
        ("[input]\nmean = 1\nmultiple_of = 9\n", r"multiple_of = 9; wanted 1 or 2"),
        ("[input]\nmean = 1\nmedian = 1\n", r"unknown field 'median' in \[input\]"),
    ],
    ids=["missing", "nan", "type", "choice", "unknown"],
)
def test_wrong_fields_are_named(
    write_doubler: Callable[..., Path], rest: str, message: str
) -> None:
    model = declare(write_doubler(), rest)
    with pytest.raises(InputError, match=rf"double\.toml: .*{message}"):
        read_declared(Declared, model, TABLES, {"input.multiple_of": (1, 2)})
