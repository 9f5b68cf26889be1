"""Where things are, from a wheel, a checkout, and any folder."""

from pathlib import Path

import pytest

from lrsr import paths
from lrsr.errors import InputError


def package(at: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = at / "site" / "lrsr"
    folder.mkdir(parents=True)
    monkeypatch.setattr(paths, "PACKAGE", folder)
    return folder


def configuration(folder: Path) -> Path:
    folder.mkdir()
    (folder / "demo.yaml").touch()
    return folder


def test_no_path_stays_none_and_an_empty_one_is_refused(tmp_path: Path) -> None:
    assert paths.path_if_any(None) is None
    assert paths.path_if_any(str(tmp_path / "a" / "..")) == tmp_path.resolve()
    with pytest.raises(InputError, match="a path is empty"):
        paths.path_if_any("")


def test_the_configuration_is_absolute_from_any_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert paths.config_folder().is_absolute()
    assert (paths.config_folder() / "demo.yaml").is_file()


def test_the_wheels_configuration_comes_before_the_checkouts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = package(tmp_path, monkeypatch)
    checkout = configuration(folder.parent / "conf")
    assert paths.config_folder() == checkout
    wheel = configuration(folder / "conf")
    assert paths.config_folder() == wheel


def test_no_configuration_is_a_broken_installation(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package(tmp_path, monkeypatch)
    with pytest.raises(InputError, match="reinstall lrsr"):
        paths.config_folder()


def test_an_asset_lies_in_the_package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = package(tmp_path, monkeypatch)
    weights = folder / "assets" / "weights" / "a.safetensors"
    weights.parent.mkdir(parents=True)
    weights.touch()
    assert paths.asset("weights/a.safetensors") == weights


def test_a_missing_asset_is_named() -> None:
    with pytest.raises(InputError, match=r"weights/none\.safetensors is missing"):
        paths.asset("weights/none.safetensors")


def test_the_cache_is_where_lrsr_cache_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("LRSR_CACHE", "renders")
    assert paths.cache_folder() == tmp_path / "renders"


@pytest.mark.parametrize(
    ("base", "wanted"), [("/somewhere", "/somewhere/lrsr"), ("", "~/.cache/lrsr")]
)
def test_the_cache_is_the_users_otherwise(
    base: str, wanted: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("LRSR_CACHE", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", base)
    assert paths.cache_folder() == Path(wanted).expanduser()
