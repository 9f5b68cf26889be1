"""A file comes over a bad line whole and right, or not at all."""

import hashlib
from collections.abc import Iterator
from pathlib import Path

import pytest
from fakes.server import Server, serving

from lrsr import download as module
from lrsr.download import download
from lrsr.errors import InputError

CONTENT = bytes(range(256)) * 400
SHA256 = hashlib.sha256(CONTENT).hexdigest()


@pytest.fixture
def server(monkeypatch: pytest.MonkeyPatch) -> Iterator[Server]:
    monkeypatch.setattr(module, "_PAUSE_S", 0.0)
    monkeypatch.setenv("NO_PROXY", "127.0.0.1")
    with serving(CONTENT) as running:
        yield running


def fetch(server: Server, folder: Path, **told: object) -> Path:
    known = {"sha256": SHA256, "size": len(CONTENT), "stall_s": 0.2, "progress": False}
    return download(f"{server.url}/net.onnx", folder / "net.onnx", **{**known, **told})


@pytest.mark.parametrize(
    "moods",
    [
        ["well"],
        ["cut", "well"],
        ["cut", "cut", "busy", "busy", "busy", "cut", "well"],
        ["stall", "well"],
        ["short", "well"],
        ["cut", "no-range"],
        ["cut", "other-range", "well"],
        ["busy", "busy", "well"],
    ],
    ids="-".join,
)
@pytest.mark.parametrize("known", [True, False], ids=["known", "unknown"])
def test_a_file_comes_whole(server: Server, tmp_path: Path, moods: list[str], known: bool) -> None:
    if not known and "short" in moods:
        pytest.skip("what nobody knows the size of is as long as the server says")
    server.moods = list(moods)
    told = {} if known else {"sha256": "", "size": 0}
    assert fetch(server, tmp_path, **told).read_bytes() == CONTENT
    assert [path.name for path in tmp_path.iterdir()] == ["net.onnx"]


def test_only_what_is_missing_is_asked_for(server: Server, tmp_path: Path) -> None:
    server.moods = ["cut", "well"]
    fetch(server, tmp_path)
    assert server.ranges == [None, f"bytes={3 << 14}-"]  # whole chunks of the half that came


def test_what_an_earlier_command_left_is_gone_on_with(server: Server, tmp_path: Path) -> None:
    (tmp_path / "net.onnx.partial").write_bytes(CONTENT[:1000])
    fetch(server, tmp_path)
    assert server.ranges == ["bytes=1000-"]


@pytest.mark.parametrize("size", [len(CONTENT), 0])
def test_what_was_whole_already_is_not_fetched_again(
    server: Server, tmp_path: Path, size: int
) -> None:
    (tmp_path / "net.onnx.partial").write_bytes(CONTENT)
    assert fetch(server, tmp_path, size=size).read_bytes() == CONTENT
    assert server.ranges == [f"bytes={len(CONTENT)}-"]


def test_what_is_longer_than_the_servers_file_is_fetched_anew(
    server: Server, tmp_path: Path
) -> None:
    (tmp_path / "net.onnx.partial").write_bytes(CONTENT + b"more")
    assert fetch(server, tmp_path).read_bytes() == CONTENT


def test_a_line_that_stays_dead_is_told_and_what_came_is_kept(
    server: Server, tmp_path: Path
) -> None:
    server.moods = ["cut", "busy"]
    with pytest.raises(InputError, match=rf"{3 << 14} bytes came.*goes on from"):
        fetch(server, tmp_path)
    assert (tmp_path / "net.onnx.partial").exists()


@pytest.mark.parametrize(
    ("mood", "told", "says"),
    [
        ("gone", {}, "the server says 404"),
        ("page", {"size": 0}, "has sha256 .*, wanted"),
        ("well", {"sha256": "0" * 64}, f"has sha256 {SHA256}, wanted 0000"),
        ("well", {"size": len(CONTENT) - 1}, "sends more than"),
        ("more", {}, "sends more than"),
    ],
)
def test_another_file_is_refused_and_nothing_is_left(
    server: Server, tmp_path: Path, mood: str, told: dict[str, object], says: str
) -> None:
    server.moods = [mood]
    with pytest.raises(InputError, match=says) as caught:
        fetch(server, tmp_path, **told)
    assert "\n" not in str(caught.value)
    assert list(tmp_path.iterdir()) == []


def test_fewer_bytes_than_there_should_be_are_refused(server: Server, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=f"has {len(CONTENT)} bytes, wanted {len(CONTENT) + 1}"):
        fetch(server, tmp_path, size=len(CONTENT) + 1)


def test_nobody_at_home_is_told_in_a_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_PAUSE_S", 0.0)
    monkeypatch.setenv("NO_PROXY", "127.0.0.1")
    with pytest.raises(InputError, match="0 bytes came") as caught:
        download("http://127.0.0.1:9/net.onnx", tmp_path / "net.onnx", progress=False)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("url", ["net.onnx", "http://", "ftp://x/net.onnx"])
def test_what_is_no_address_is_refused(tmp_path: Path, url: str) -> None:
    with pytest.raises(InputError, match="give another"):
        download(url, tmp_path / "net.onnx", progress=False)


def test_the_proxy_of_the_environment_is_used(
    server: Server, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("NO_PROXY")
    monkeypatch.delenv("no_proxy", raising=False)
    monkeypatch.setenv("http_proxy", server.url)
    download("http://far.invalid/net.onnx", tmp_path / "net.onnx", sha256=SHA256, progress=False)
    assert server.paths == ["http://far.invalid/net.onnx"]
