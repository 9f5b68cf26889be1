"""``lrsr upscale`` as a user types it, and somebody's network in it and in ``lrsr eval``."""

from collections.abc import Callable
from pathlib import Path

import onnx
import pytest
from onnx import TensorProto, helper
from PIL import Image

from lrsr.cli import main


@pytest.fixture(autouse=True)
def somewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "it's here, now"
    folder.mkdir()
    monkeypatch.chdir(folder)
    for name in ("a (1).jpg", "b,c.png"):
        Image.new("RGB", (6, 4), (200, 10, 10)).save(name)


@pytest.fixture
def theirs() -> Callable[..., Path]:
    """Depth to space, 2x, of twelve channels that repeat three: nearest neighbour."""
    repeat = onnx.numpy_helper.from_array
    import numpy as np

    kernel = np.repeat(np.eye(3, dtype=np.float32), 4, axis=0)[:, :, None, None]
    graph = helper.make_graph(
        [
            helper.make_node("Conv", ["x", "w"], ["many"]),
            helper.make_node("DepthToSpace", ["many"], ["y"], blocksize=2, mode="CRD"),
        ],
        "theirs",
        [helper.make_tensor_value_info("x", TensorProto.FLOAT, ["N", 3, "H", "W"])],
        [helper.make_tensor_value_info("y", TensorProto.FLOAT, ["N", 3, "H2", "W2"])],
        [repeat(kernel, "w")],
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 18)], ir_version=9)
    onnx.save(model, "theirs.onnx")
    return lambda: Path("theirs.onnx")


def sizes(folder: str) -> dict[str, tuple[int, int]]:
    files = [path for path in Path(folder).iterdir() if path.suffix in {".jpg", ".png"}]
    return {path.name: opened(path).size for path in files}


def opened(path: Path) -> Image.Image:
    with Image.open(path) as image:
        image.load()
    return image


@pytest.mark.parametrize(
    "words",
    [
        ["a (1).jpg", "b,c.png"],
        ["images=."],
        ["images=['a (1).jpg','b,c.png']"],
        ["."],
    ],
    ids=" ".join,
)
def test_pictures_are_named_in_any_way(words: list[str]) -> None:
    assert main(["upscale", *words, "out=large", "sr=bicubic2"]) == 0
    assert sizes("large") == {"a (1).jpg": (12, 8), "b,c.png": (12, 8)}
    assert {path.name for path in Path("large").iterdir()} > {"config.yaml", "versions.json"}


def test_somebodys_network_needs_two_words(theirs: Callable[..., Path]) -> None:
    words = ["upscale", "b,c.png", "out=large", "sr=onnx", f"sr.model={theirs()}"]
    assert main([*words, "sr.contract.scale=2", "sr.contract.channels=RGB"]) == 0
    assert sizes("large") == {"b,c.png": (12, 8)}
    assert opened(Path("large/b,c.png")).getcolors() == [(96, (200, 10, 10))]


def test_a_multirun_has_a_folder_for_each() -> None:
    assert main(["upscale", "-m", "b,c.png", "out=large", "sr=bicubic2,bicubic4"]) == 0
    assert sizes("large/0") | {"4": sizes("large/1")["b,c.png"]} == {
        "b,c.png": (12, 8),
        "4": (24, 16),
    }


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["upscale", "out=x"], "images must be given"),
        (["upscale", "b,c.png"], "out must be given"),
        (["upscale", "b,c.png", "out=null"], "out=null: give the folder"),
        (["upscale", "b,c.png", "out=x", "sr=srcnn9"], "sr=srcnn9: no such option"),
        (["upscale", "b,c.png", "out=x", "sr=onnx"], "sr.model must be given"),
        (["upscale", "b,c.png", "out=x", "sr=foreign"], "sr.model must be given"),
        (["upscale", "b,c.png", "out=x", "sr=onnx", "sr.model=n.onnx"], "n.onnx is missing"),
        (["upscale", "b,c.png", "out=x", "sr=onnx", "sr.modle=n"], "did you mean model?"),
        (["upscale", "b,c.png", "out=x", "colour=1"], "no setting 'colour'"),
        (["upscale", "gone.png", "out=x", "sr=bicubic2"], "gone.png does not exist"),
    ],
    ids=lambda value: " ".join(value[1:]) if isinstance(value, list) else None,
)
def test_a_mistake_is_told_in_one_line(
    words: list[str], says: str, capfd: pytest.CaptureFixture[str]
) -> None:
    assert main(words) == 2
    lines = [line for line in capfd.readouterr().err.splitlines() if line.startswith("lrsr: ")]
    assert len(lines) == 1
    assert says in lines[0]
