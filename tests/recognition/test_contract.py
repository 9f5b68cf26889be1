from dataclasses import asdict
from pathlib import Path

import pytest

from lrsr.errors import InputError
from lrsr.onnx import contract_path, sha256_of
from lrsr.recognition.contract import read_contract, write_contract


def edit(model: Path, old: str, new: str) -> None:
    path = contract_path(model)
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))


def test_a_contract_is_read_back_as_it_was_written(tiny_model: Path) -> None:
    contract = read_contract(tiny_model)
    assert write_contract(contract) == contract_path(tiny_model).read_text()
    assert asdict(contract)["mean"] == 127.5


def test_the_sha256_is_that_of_the_bytes(tmp_path: Path) -> None:
    path = tmp_path / "abc"
    path.write_bytes(b"abc")  # FIPS 180-2, appendix B.1
    expected = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
    assert sha256_of(path) == expected


def test_quotes_and_backslashes_survive(tmp_path: Path, tiny_model: Path) -> None:
    from dataclasses import replace

    odd = replace(read_contract(tiny_model), source='a "b" \\ c')
    contract_path(tiny_model).write_text(write_contract(odd))
    assert read_contract(tiny_model) == odd


def test_three_means_and_an_output_are_read_back(tiny_model: Path) -> None:
    from dataclasses import replace

    several = replace(read_contract(tiny_model), mean=(104.0, 117.0, 123.0), name="embeddings")
    contract_path(tiny_model).write_text(write_contract(several))
    assert read_contract(tiny_model) == several


def test_a_whole_number_does_for_a_mean(tiny_model: Path) -> None:
    edit(tiny_model, "mean = 127.5", "mean = 0")
    assert read_contract(tiny_model).mean == 0.0


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('layout = "NCHW"', 'layout = "CHWN"', "input.layout = 'CHWN'; wanted NCHW or NHWC"),
        ('channels = "RGB"', 'channels = "GRB"', "wanted RGB or BGR"),
        ("height_px = 112", "height_px = 8", "input is 8×112 px; wanted 16 to 1024 each"),
        ("mean = 127.5", "mean = [1, 2]", "input.mean = [1, 2]; wanted a number, or three"),
        ("mean = 127.5", 'mean = [1, 2, "3"]', "wanted a number, or three"),
        ("scale = 127.5", "scale = [1, 0, 1]", "must be above 0"),
        ("mean = 127.5\n", "", "input.mean is missing"),
        ("mean = 127.5", 'mean = "127"', "input.mean = '127'; wanted a number, or three"),
        ("antialias = false", "antialias = 0", "wanted bool"),
        ("scale = 127.5", "scale = 0.0", "must be above 0"),
        ("dimension = 6", "dimension = 6\nnorm = 1", "unknown field 'norm'"),
        ('licence = "MIT"', 'license = "MIT"', "unknown field 'license'"),
        ("[alignment]", "[alignement]", "unknown field 'alignement'"),
        ("[output]", "[output", "cannot be read as a contract"),
        ('template = "arcface5"', 'template = "nose"', "wanted arcface5 or eyes or deepface"),
    ],
)
def test_a_wrong_contract_is_named_in_one_line(
    tiny_model: Path, old: str, new: str, message: str
) -> None:
    edit(tiny_model, old, new)
    with pytest.raises(InputError, match=r"tiny\.toml") as caught:
        read_contract(tiny_model)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_another_models_contract_is_refused(tiny_model: Path) -> None:
    tiny_model.write_bytes(tiny_model.read_bytes() + b"\0")
    with pytest.raises(InputError, match=r"tiny\.onnx: sha256 is .* damaged or is another model"):
        read_contract(tiny_model)


def test_a_table_must_be_a_table(tiny_model: Path) -> None:
    text = contract_path(tiny_model).read_text().split("[input]")[0]
    contract_path(tiny_model).write_text(text + "input = 3\n")
    with pytest.raises(InputError, match=r"input = 3; make it a table"):
        read_contract(tiny_model)


@pytest.mark.parametrize("which", ["tiny.onnx", "tiny.toml"])
def test_a_missing_file_is_named(tiny_model: Path, which: str) -> None:
    (tiny_model.parent / which).unlink()
    with pytest.raises(InputError, match=rf"{which} is missing: a model needs"):
        read_contract(tiny_model)
