"""A server of one file that stalls, breaks off, lies or refuses, as real ones do."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer


class Server(ThreadingHTTPServer):
    """Serves ``content`` at every path; each request takes the next of ``moods``, then the last.

    Moods: "well"; "cut": half of what is asked for, and the line breaks; "stall": half, then
    nothing; "short": half, and its length as if it were all; "no-range": from the start whatever
    is asked for; "other-range": another part than asked for; "busy": 503; "gone": 404;
    "more": endless; "page": a page of HTML in the place of the file.
    """

    daemon_threads = True

    def __init__(self, content: bytes) -> None:
        super().__init__(("127.0.0.1", 0), _Handler)
        self.content, self.moods = content, ["well"]
        self.ranges: list[str | None] = []
        self.paths: list[str] = []
        self.released = threading.Event()

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.server_port}"


class _Handler(BaseHTTPRequestHandler):
    server: Server

    def do_GET(self) -> None:
        server = self.server
        mood = server.moods.pop(0) if len(server.moods) > 1 else server.moods[0]
        asked = self.headers.get("Range")
        server.ranges.append(asked)
        server.paths.append(self.path)
        if mood in ("busy", "gone"):
            self.send_error(503 if mood == "busy" else 404)
            return
        content = b"<html>Sign in</html>" if mood == "page" else server.content
        start = int(asked.removeprefix("bytes=").removesuffix("-")) if asked else 0
        if mood == "no-range":
            start = 0
        if start >= len(content):
            self.send_response(416)
            self.send_header("Content-Range", f"bytes */{len(content)}")
            self.send_header("Content-Length", "0")
            self.end_headers()
            return
        part = content[start:]
        half = part[: len(part) // 2 + 1]
        self.send_response(206 if start else 200)
        if start:
            told = start + 1 if mood == "other-range" else start
            self.send_header("Content-Range", f"bytes {told}-{len(content) - 1}/{len(content)}")
        if mood != "more":
            length = len(half) if mood == "short" else len(part)
            self.send_header("Content-Length", str(length))
        self.end_headers()
        if mood == "more":
            self._flood()
        else:
            self.wfile.write(half if mood in ("cut", "stall", "short") else part)
        if mood == "stall":
            server.released.wait(30)

    def _flood(self) -> None:
        try:
            for _ in range(1000):
                self.wfile.write(bytes(1 << 16))
        except OSError:
            pass  # the other side has had enough

    def log_message(self, *_: object) -> None:
        pass


@contextmanager
def serving(content: bytes) -> Iterator[Server]:
    """Run a server while the block lasts."""
    with Server(content) as server:
        thread = threading.Thread(target=server.serve_forever, args=(0.01,))
        thread.start()
        try:
            yield server
        finally:
            server.released.set()
            server.shutdown()
            thread.join()
