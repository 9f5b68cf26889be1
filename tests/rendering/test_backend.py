"""Which variant is chosen, with libraries that are broken, absent, or abort the process."""

import logging
import os
import re
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

from lrsr.errors import InputError
from lrsr.rendering import backend
from lrsr.rendering.backend import _Backend, _find_llvm, _start, choose_variant


@pytest.fixture(autouse=True)
def _clean(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("LRSR_CACHE", str(tmp_path / "cache"))
    monkeypatch.delenv("LRSR_VARIANT", raising=False)
    monkeypatch.setattr(backend, "_cuda_driver", lambda: None)


@pytest.fixture
def children(monkeypatch: pytest.MonkeyPatch) -> list[Path | None]:
    """Answer for the child process: names with "good" work. Records who was asked."""
    asked: list[Path | None] = []

    def answer(variant: str, library: Path | None) -> str:
        asked.append(library)
        return "" if library is None or "good" in library.name else "status -6"

    monkeypatch.setattr(backend, "_run_probe", answer)
    return asked


def library(folder: Path, name: str) -> Path:
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(name.encode())
    return path


def test_the_first_library_that_works_is_taken(tmp_path: Path, children: list) -> None:
    bad, good = library(tmp_path, "bad.so"), library(tmp_path, "good.so")
    assert choose_variant([bad, good]) == _Backend("llvm_ad_rgb", f"{good} renders", good)
    assert children == [bad, good]


def test_a_gpu_comes_first(monkeypatch: pytest.MonkeyPatch, children: list) -> None:
    monkeypatch.setattr(backend, "_cuda_driver", lambda: "12080")
    assert choose_variant([]).variant == "cuda_ad_rgb"


def test_a_gpu_that_does_not_render_is_passed_over(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(backend, "_cuda_driver", lambda: "12080")
    monkeypatch.setattr(
        backend, "_run_probe", lambda variant, _: "no OptiX" if "cuda" in variant else ""
    )
    assert choose_variant([library(tmp_path, "good.so")]).variant == "llvm_ad_rgb"


def test_without_any_llvm_the_slow_variant_says_why(tmp_path: Path, children: list) -> None:
    chosen = choose_variant([library(tmp_path, "bad.so")])
    assert chosen.variant == "scalar_rgb"
    assert "bad.so: status -6" in chosen.reason
    assert "pip install karellen-llvm-core" in chosen.reason
    assert "no LLVM found" not in chosen.reason


def test_no_candidates_is_scalar(children: list) -> None:
    assert choose_variant([]).variant == "scalar_rgb"


def test_a_verdict_is_asked_for_once(tmp_path: Path, children: list) -> None:
    candidates = [library(tmp_path, "bad.so"), library(tmp_path, "good.so")]
    assert choose_variant(candidates) == choose_variant(candidates)
    assert len(children) == 2


def test_a_new_library_of_the_same_name_is_asked_again(tmp_path: Path, children: list) -> None:
    good = library(tmp_path, "good.so")
    choose_variant([good])
    good.write_bytes(b"another release")
    choose_variant([good])
    assert children == [good, good]


def test_a_broken_record_is_asked_again(tmp_path: Path, children: list) -> None:
    good = library(tmp_path, "good.so")
    choose_variant([good])
    for record in (tmp_path / "cache").rglob("*.json"):
        record.write_text("{")
    assert choose_variant([good]).variant == "llvm_ad_rgb"
    assert len(children) == 2


def test_a_timeout_is_remembered_by_its_process_alone(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, children: list
) -> None:
    good = library(tmp_path, "good.so")
    with monkeypatch.context() as busy:
        busy.setattr(backend, "_run_probe", lambda *_: backend._TIMED_OUT)
        assert choose_variant([good]).variant == "scalar_rgb"
    assert choose_variant([good]).variant == "scalar_rgb"  # what names the pictures of a process
    monkeypatch.setattr(backend, "_GIVEN_UP", set())
    assert choose_variant([good]).variant == "llvm_ad_rgb"


def test_a_read_only_cache_does_not_matter(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, children: list
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("LRSR_CACHE", str(tmp_path / "file"))
    assert choose_variant([library(tmp_path, "good.so")]).variant == "llvm_ad_rgb"


def test_the_user_may_choose(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LRSR_VARIANT", "scalar_rgb")
    assert choose_variant() == _Backend("scalar_rgb", "LRSR_VARIANT=scalar_rgb (slow)")


def test_wavelengths_are_traced_only_where_that_is_asked_for(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, children: list
) -> None:
    good = library(tmp_path, "good.so")
    assert choose_variant([good]).variant == "llvm_ad_rgb"
    monkeypatch.setenv("LRSR_VARIANT", "llvm_ad_spectral")
    said = "LRSR_VARIANT=llvm_ad_spectral"
    assert choose_variant([good]) == _Backend("llvm_ad_spectral", said, good)
    monkeypatch.setenv("LRSR_VARIANT", "cuda_ad_spectral")
    with pytest.raises(InputError, match="CUDA: no driver"):
        choose_variant([good])


def test_an_unknown_choice_names_the_known(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LRSR_VARIANT", "gpu")
    with pytest.raises(InputError, match="LRSR_VARIANT=gpu: choose one of cuda_ad_rgb, llvm"):
        choose_variant()


def test_a_choice_that_cannot_run_is_refused(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, children: list
) -> None:
    monkeypatch.setenv("LRSR_VARIANT", "llvm_ad_rgb")
    with pytest.raises(InputError, match=r"does not work here .*bad\.so: status -6.*unset it"):
        choose_variant([library(tmp_path, "bad.so")])
    monkeypatch.setenv("LRSR_VARIANT", "cuda_ad_rgb")
    with pytest.raises(InputError, match="CUDA: no driver"):
        choose_variant()


def test_start_refuses_a_choice_that_cannot_be_met(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LRSR_VARIANT", "cuda_ad_rgb")
    monkeypatch.setattr(backend, "_begin", cache(backend._begin.__wrapped__))
    with pytest.raises(InputError, match="does not work here"):
        backend._start()


def test_libraries_of_the_environment_come_before_the_systems_newest_first(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.delenv("DRJIT_LIBLLVM_PATH", raising=False)
    monkeypatch.setattr(backend, "_SYSTEM_FOLDERS", (str(tmp_path / "lib"),))
    monkeypatch.setattr(sys, "prefix", str(tmp_path / "env"))
    monkeypatch.setattr(
        backend.sysconfig, "get_paths", lambda: {"purelib": str(tmp_path / "env/lib/py/site")}
    )
    monkeypatch.setattr(sys, "path", ["", str(tmp_path / "below/lib/python3/site-packages")])
    own = library(tmp_path, "env/lib/libLLVM.so.23.1")
    below = library(tmp_path, "below/lib/libLLVM.so.24.1")  # an environment that this one uses
    old = library(tmp_path, "lib/x86_64-linux-gnu/libLLVM-9.so.1")
    new = library(tmp_path, "lib/x86_64-linux-gnu/libLLVM-15.so.1")
    library(tmp_path, "lib/llvm-15/lib/libLLVMSupport.a")
    (tmp_path / "lib/libLLVM.so").symlink_to(new)
    assert [path.resolve() for path in _find_llvm()] == [own, below, new, old]


def test_the_users_library_comes_first(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    mine = library(tmp_path, "libLLVM-mine.so")
    monkeypatch.setenv("DRJIT_LIBLLVM_PATH", str(mine))
    assert _find_llvm()[0] == mine


def test_a_child_that_aborts_leaves_us_alive(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(backend, "_PROBE", "import os; os.abort()")
    assert "status -6" in choose_variant([library(tmp_path, "old.so")]).reason


def test_a_file_that_is_no_library_fails_the_true_probe(tmp_path: Path) -> None:
    chosen = choose_variant([library(tmp_path, "libLLVM-99.so")])
    assert chosen.variant == "scalar_rgb"
    assert "libLLVM-99.so: status 1" in chosen.reason


def test_a_child_that_hangs_is_given_up(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(backend, "_PROBE", "import time; time.sleep(60)")
    monkeypatch.setattr(backend, "_PROBE_SECONDS", 0.2)
    assert backend._TIMED_OUT in choose_variant([library(tmp_path, "slow.so")]).reason


def test_the_choice_is_logged_once(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    chosen = _start().variant()
    monkeypatch.setattr(backend, "choose_variant", lambda: _Backend(chosen, "it was asked for"))
    backend._begin.cache_clear()
    with caplog.at_level(logging.INFO, logger=backend.__name__):
        _start()
        _start()
    assert len(caplog.messages) == 1
    assert "it was asked for" in caplog.text


def test_importing_the_package_does_not_import_mitsuba() -> None:
    code = "import sys, lrsr.rendering, lrsr.rendering.scene; sys.exit('mitsuba' in sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True, env=dict(os.environ))


def test_no_module_of_the_tests_imports_drjit_before_its_llvm_is_chosen() -> None:
    """Doctests import every module, and who imports Dr.Jit first decides on the library."""
    tests = Path(__file__).parents[1]
    early = re.compile(r"^(import|from) (drjit|mitsuba)\b", re.MULTILINE)
    assert [path for path in tests.rglob("*.py") if early.search(path.read_text())] == []
