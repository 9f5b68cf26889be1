"""Where things are, from a wheel, a checkout, and any folder."""

import os
import tempfile
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
    assert paths.path_if_any(None, "out") is None
    assert paths.path_if_any(str(tmp_path / "a" / ".."), "out") == tmp_path.resolve()
    with pytest.raises(InputError, match="a path is empty"):
        paths.path_if_any("", "out")


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


def test_a_users_path_is_absolute_and_its_home_is_known(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    assert paths.user_path("~/größe (1)") == tmp_path / "home" / "größe (1)"
    assert paths.user_path("a b") == tmp_path / "a b"


@pytest.mark.parametrize("text", ["", "  ", "~nobody-is-called-so/x"])
def test_a_path_that_cannot_be_meant_is_refused(text: str) -> None:
    with pytest.raises(InputError, match="write"):
        paths.user_path(text)


def test_whoever_has_no_home_has_a_cache_of_their_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    for name in ("LRSR_CACHE", "XDG_CACHE_HOME", "MPLCONFIGDIR"):
        monkeypatch.delenv(name, raising=False)
    (tmp_path / "file").touch()
    monkeypatch.setenv("HOME", str(tmp_path / "file"))
    mine = tmp_path / f"lrsr-{os.getuid()}"
    assert paths.cache_folder() == mine
    assert mine.stat().st_mode & 0o777 == 0o700
    paths.prepare_home()
    assert os.environ["MPLCONFIGDIR"] == str(mine)


def test_a_home_that_can_only_be_read_still_serves_its_cache(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("LRSR_CACHE", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "other"))
    (tmp_path / "other").mkdir()
    monkeypatch.setattr(os, "access", lambda path, mode: False)
    assert paths.cache_folder().is_relative_to(tmp_path / "other")
    (tmp_path / "lrsr").mkdir()
    assert paths.cache_folder() == tmp_path / "lrsr"


def test_a_temporary_folder_that_somebody_else_laid_out_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    (tmp_path / "theirs").mkdir()
    (tmp_path / f"lrsr-{os.getuid()}").symlink_to("theirs")
    with pytest.raises(InputError, match="somebody else's: set LRSR_CACHE"):
        paths._scratch_folder()


@pytest.mark.parametrize("base", ["cache", "", "./x"])
def test_a_relative_cache_home_is_none(base: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("LRSR_CACHE", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", base)
    assert paths.cache_folder() == Path("~/.cache/lrsr").expanduser()


def test_an_empty_lrsr_cache_is_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LRSR_CACHE", " ")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert paths.cache_folder() == tmp_path / "lrsr"
