from pathlib import Path
from typing import Any

import pytest
import torch

from lrsr.training import precision
from lrsr.training.precision import _has_bfloat16, choose_precision


@pytest.mark.parametrize(
    ("cpuinfo", "expected"),
    [
        pytest.param("processor : 0\nflags\t\t: fpu avx512f avx512_bf16\n", True, id="x86 bf16"),
        pytest.param("processor : 0\nflags\t\t: fpu amx_bf16 amx_tile\n", True, id="x86 amx"),
        pytest.param("processor : 0\nflags\t\t: fpu avx512f avx512vl\n", False, id="x86 without"),
        pytest.param("Features\t: fp asimd bf16 i8mm\n", True, id="arm bf16"),
        pytest.param("Features\t: fp asimd i8mm\n", False, id="arm without"),
        pytest.param("model name : bf16 machine\n", False, id="a name is no flag"),
        pytest.param("", False, id="empty"),
    ],
)
def test_bfloat16_is_read_from_the_flags(cpuinfo: str, expected: Any) -> None:
    assert _has_bfloat16(cpuinfo) is expected


@pytest.mark.parametrize(
    ("flags", "expected"), [("avx512_bf16", "bf16-mixed"), ("avx2", "32-true")], ids=str
)
def test_cpu_precision_follows_its_instructions(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, flags: str, expected: Any
) -> None:
    (tmp_path / "cpuinfo").write_text(f"flags : {flags}\n")
    monkeypatch.setattr(precision, "_CPUINFO", tmp_path / "cpuinfo")
    assert choose_precision("cpu")[0] == expected


def test_unknown_processor_trains_in_float32(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(precision, "_CPUINFO", tmp_path / "none")
    assert choose_precision("cpu")[0] == "32-true"


def test_gpu_trains_in_float32(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(torch.cuda, "is_available", lambda: True)
    assert choose_precision("auto")[0] == "32-true"
