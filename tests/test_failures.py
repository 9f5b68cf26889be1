"""Each kind of failure is told as the user's to mend, or as ours."""

import errno
import os

import pytest
from hydra.errors import ConfigCompositionException, InstantiationException
from hydra.utils import instantiate
from omegaconf import OmegaConf
from omegaconf.errors import InterpolationKeyError

from lrsr.errors import InputError
from lrsr.failures import explain


def caused(error: Exception, cause: Exception) -> Exception:
    try:
        raise error from cause
    except Exception as raised:
        return raised


NUMBERS = (
    "EACCES EPERM EROFS ENOSPC EDQUOT ENAMETOOLONG ENOTDIR EISDIR EEXIST ENOENT ELOOP EMFILE EIO"
)


@pytest.mark.parametrize("name", NUMBERS.split())
def test_a_file_that_the_system_refuses_is_the_users_to_mend(name: str) -> None:
    reason = os.strerror(getattr(errno, name))
    status, line = explain(OSError(getattr(errno, name), reason, "runs/a b"), [])
    assert status == 2
    assert line == f"cannot use runs/a b: {reason}; mend that or choose another"


@pytest.mark.parametrize(
    "error",
    [
        OSError(errno.ENOSPC, "No space left on device"),
        RuntimeError("basic_ios::clear: iostream error"),
        RuntimeError("PytorchStreamWriter failed writing file data/0"),
        caused(RuntimeError("plot"), OSError(errno.ENOSPC, "No space left on device")),
    ],
    ids=repr,
)
def test_a_full_disk_is_told_whoever_wrote(error: Exception) -> None:
    status, line = explain(error, [])
    assert status == 2
    assert "space" in line


def test_torchs_second_error_does_not_hide_the_full_disk() -> None:
    error = RuntimeError("unexpected pos 64 vs 0")
    error.__context__ = RuntimeError("basic_ios::clear: iostream error")
    assert explain(error, [])[0] == 2


def test_a_name_that_is_no_utf_8_is_told_and_not_the_file_that_it_was_for() -> None:
    name = os.fsdecode(b"bad\xff.png")
    with pytest.raises(UnicodeEncodeError) as raised:
        ("line\n" * 1000 + name + "line\n" * 1000).encode()
    status, line = explain(raised.value, [])
    assert status == 2
    assert r"bad\udcff.png" in line
    assert len(line) < 300


@pytest.mark.parametrize(
    "error", [OSError("nothing of a file"), ConnectionError(), RuntimeError("x"), TypeError("x")]
)
def test_the_rest_is_ours(error: Exception) -> None:
    status, line = explain(error, ["out=x"])
    assert status == 1
    assert line.startswith("a fault of ours: ")


def not_built(**given: object) -> InstantiationException:
    with pytest.raises(InstantiationException) as refused:
        instantiate({"part": {"_target_": "lrsr.errors.InputError", **given}})
    return refused.value


def test_an_input_error_inside_a_part_is_told_as_it_is() -> None:
    error = caused(
        InstantiationException("x\nfull_key: part"), InputError("f_number=0: wanted > 0")
    )
    assert explain(error, []) == (2, "f_number=0: wanted > 0")


@pytest.mark.parametrize("word", ["part=FILE.yaml", "+part.wrong=1", "part.wrong=1"])
def test_a_part_that_the_user_has_touched_is_the_users(word: str) -> None:
    status, line = explain(not_built(wrong=1), [word])
    assert status == 2
    assert "part" in line


def test_a_part_that_the_user_has_not_touched_is_ours() -> None:
    assert explain(not_built(wrong=1), ["seed=1", "partial=2"])[0] == 1


def test_a_wrong_field_is_named_with_the_known_ones() -> None:
    with pytest.raises(InstantiationException) as refused:
        instantiate({"word": {"_target_": "lrsr.overrides.Overrides", "comand": "x"}})
    status, line = explain(refused.value, ["word.comand=x"])
    assert (status, line) == (2, "no setting 'word.comand': word has command, folders, sweep")


def test_a_list_in_place_of_settings_is_told_as_it_was_typed() -> None:
    cause = TypeError("Cannot merge DictConfig with ListConfig")
    error = caused(ConfigCompositionException("Error merging override ++axes=[pose]"), cause)
    wanted = "axes=[pose]: wanted settings, one by one: axes.NAME=..."
    assert explain(error, ["axes=[pose]"]) == (2, wanted)


def test_a_reference_to_nothing_is_told_with_its_setting() -> None:
    with pytest.raises(InterpolationKeyError) as raised:
        _ = OmegaConf.create({"a": {"format": "${nosuch}"}}).a.format
    status, line = explain(raised.value, [])
    assert status == 2
    assert line.startswith("a.format: Interpolation key 'nosuch' not found")
