"""What does a video codec leave of a face? H.264 or motion JPEG, of several frames, in a frame.

A recorder's picture of a face is mostly a P frame: what changed since the frame before, in
macroblocks of 16 × 16 pixels (ITU-T H.264, sec. 7.4.5), with noise of its own in each frame. So the
face is placed in a larger frame, where its macroblocks fall as ``origin_px`` says, several frames
of it are encoded by FFmpeg (libx264, mjpeg) through PyAV, and the last one is decoded and cut out.
There is no gradient. The stand-in for training is :func:`lrsr.camera.codec.jpeg_differentiable` at
a quality that loses as much (``_STAND_IN``), but not the same: on rendered faces of 52 pixels
H.264 at a constant rate factor of 18, 28, 38 keeps 36.9, 32.0, 27.1 dB, the stand-in as much within
0.1 dB (0.7 dB at 26 and 104 pixels), and the two are 37.5, 32.0, 26.9 dB apart, as far as either is
from the original. Train through it for the amount of loss; evaluate with the true codec.
"""

from collections.abc import Sequence
from fractions import Fraction

import av
import numpy as np
import torch
from av.video.frame import PictureType
from torch import nn
from torch.nn import functional as F

from lrsr.camera.checks import check_choice, check_origin, check_setting, check_srgb, number, whole
from lrsr.camera.codec import jpeg_differentiable
from lrsr.images import check_images

_CODECS = {"h264": ("libx264", "yuv420p"), "mjpeg": ("mjpeg", "yuvj422p")}
"""Encoders of FFmpeg, and the samples of colour that cameras give them."""

_STAND_IN = {
    "h264": {18: 91, 23: 82, 28: 59, 33: 26, 38: 12, 43: 6},
    "mjpeg": {2: 91, 4: 78, 8: 41, 16: 17, 31: 9},
}
"""JPEG quality of equal loss, by constant rate factor: measured on four rendered faces of 52 pixels
a side without noise; in between it is interpolated."""

_STAND_IN_CHROMA = {"h264": "4:2:0", "mjpeg": "4:2:2"}

_MACROBLOCK_PX = 16
_GREY = 0.5

_CAREFUL = 0x2 | 0x2000 | 0x4000 | 0x40000 | 0x80000
"""FFmpeg's swscale: bilinear, colours interpolated fully both ways, rounded accurately, exactly the
same everywhere. Without it colours alone cost 10 dB more than 4:2:0 has to."""


class Video(nn.Module):
    """A short recording, of which the last frame is kept.

    Args:
        codec: "h264" or "mjpeg".
        crf: Constant rate factor of H.264, 0..51, more is worse; the scale of mjpeg's quantiser,
            2..31. Not used with ``bit_rate_kbps``.
        bit_rate_kbps: Of the encoded frame, at ``frames_per_s``; None: ``crf`` rules.
        frames: Exposures; the first is an I frame, the others are P frames. >= 1.
        frames_per_s: > 0.
        speed: x264's preset, from "ultrafast" to "veryslow"; recorders' chips search little.
        margin_px: Frame around the face on every side, rounded up to macroblocks.
        surround: "grey", or "edge": the face's edge repeated outwards.

    Raises:
        InputError: A value is out of its range.
    """

    def __init__(
        self,
        codec: str = "h264",
        *,
        crf: int = 28,
        bit_rate_kbps: float | None = None,
        frames: int = 3,
        frames_per_s: int = 25,
        speed: str = "veryfast",
        margin_px: int = 16,
        surround: str = "grey",
    ) -> None:
        super().__init__()
        self.codec = check_choice("codec", codec, _CODECS)
        low, high = (0, 51) if codec == "h264" else (2, 31)
        self.crf = whole("crf", crf, f"{low}..{high}", low=low, high=high)
        self.bit_rate_kbps = bit_rate_kbps
        if bit_rate_kbps is not None:
            wish = "a number > 0, or null"
            self.bit_rate_kbps = number("bit_rate_kbps", bit_rate_kbps, wish, above=0)
        self.frames = whole("frames", frames, "a whole number >= 1", low=1)
        self.frames_per_s = whole("frames_per_s", frames_per_s, "a whole number >= 1", low=1)
        self.speed = check_choice("speed", speed, _SPEEDS)
        self.margin_px = whole("margin_px", margin_px, "a whole number >= 0", low=0)
        check_setting("surround", surround, surround in {"grey", "edge"}, "grey or edge")
        self.surround = surround

    def forward(
        self,
        frames: torch.Tensor,
        *,
        origin_px: tuple[int, int] = (0, 0),
        differentiable: bool = False,
    ) -> torch.Tensor:
        """Record each image's frames, and play the last.

        Args:
            frames: ``(T, B, 3, H, W)`` float32, srgb, [0, 1]; T as the recording wants.
            origin_px: ``(x, y)`` of the face's first pixel in the camera's frame.
            differentiable: Use the stand-in, on the last frame.

        Returns:
            ``(B, 3, H, W)`` float32, [0, 1], multiples of 1/255.

        Raises:
            ImageContractError: The images break the contract.
            InputError: The place is no two whole numbers >= 0.
        """
        for frame in frames:
            check_images(check_srgb(frame), name="srgb")
        if differentiable:
            quality, chroma = self.stand_in_quality, _STAND_IN_CHROMA[self.codec]
            return jpeg_differentiable(frames[-1], quality, chroma=chroma, origin_px=origin_px)
        size = frames.shape[-2:]
        played = []
        for recording in frames.unbind(1):
            framed, x, y = self._framed(recording, check_origin(origin_px))
            pixels = framed.detach().mul(255).round().to(torch.uint8)
            shown = _play(self.record(pixels.permute(0, 2, 3, 1).cpu().numpy()), self.codec)[-1][0]
            played.append(torch.from_numpy(shown[y : y + size[0], x : x + size[1]].copy()))
        return torch.stack(played).permute(0, 3, 1, 2).contiguous().to(frames) / 255

    @property
    def stand_in_quality(self) -> int:
        """JPEG quality that the differentiable stand-in uses; a bit rate counts as ``crf``."""
        measured = _STAND_IN[self.codec]
        return round(float(np.interp(self.crf, list(measured), list(measured.values()))))

    def record(self, frames: np.ndarray) -> list[bytes]:
        """Encode ``(T, H, W, 3)`` uint8, H and W even, by one thread: the same bytes every time.

        Returns:
            A packet for each frame.
        """
        name, pixel_format = _CODECS[self.codec]
        encoder = av.CodecContext.create(name, "w")
        encoder.height, encoder.width = frames.shape[1:3]
        encoder.pix_fmt, encoder.thread_count = pixel_format, 1
        encoder.framerate = Fraction(self.frames_per_s)
        encoder.time_base = 1 / Fraction(self.frames_per_s)
        encoder.gop_size, encoder.options = len(frames), self._options()
        if self.bit_rate_kbps is not None:
            encoder.bit_rate = round(1000 * self.bit_rate_kbps)
        packets = []
        for i, rows in enumerate(frames):
            colours = av.VideoFrame.from_ndarray(np.ascontiguousarray(rows), format="rgb24")
            picture = colours.reformat(format=pixel_format, interpolation=_CAREFUL)
            picture.pts = i
            packets += [bytes(packet) for packet in encoder.encode(picture)]
        packets += [bytes(packet) for packet in encoder.encode(None)]
        return [packet for packet in packets if packet]

    def _options(self) -> dict[str, str]:
        if self.codec == "mjpeg":
            fixed = self.bit_rate_kbps is None
            return {"qmin": str(self.crf), "qmax": str(self.crf)} if fixed else {}
        options = {"preset": self.speed, "bf": "0", "sc_threshold": "0", "tune": "zerolatency"}
        return options if self.bit_rate_kbps is not None else {**options, "crf": str(self.crf)}

    def _framed(
        self, face: torch.Tensor, origin_px: tuple[int, int]
    ) -> tuple[torch.Tensor, int, int]:
        """Return frames ``(T, 3, H', W')`` with even sides, and where in them the face lies."""
        (x, y), (height, width) = origin_px, face.shape[-2:]
        margin = -(-self.margin_px // _MACROBLOCK_PX) * _MACROBLOCK_PX
        x, y = margin + x % _MACROBLOCK_PX, margin + y % _MACROBLOCK_PX
        right = margin + -(x + width) % _MACROBLOCK_PX
        bottom = margin + -(y + height) % _MACROBLOCK_PX
        frame = F.pad(face, (x, right, y, bottom), mode="replicate")
        if self.surround == "grey":
            frame = torch.full_like(frame, _GREY)
        frame[..., y : y + height, x : x + width] = face
        return frame, x, y


_SPEEDS = ("ultrafast", "superfast", "veryfast", "faster", "fast", "medium", "slow", "veryslow")


def _play(packets: Sequence[bytes], codec: str) -> list[tuple[np.ndarray, str]]:
    """Decode every frame: its pixels ``(H, W, 3)`` uint8 and its type, "I" or "P"."""
    decoder = av.CodecContext.create(codec, "r")
    decoder.thread_count = 1
    shown = []
    for packet in [*map(av.Packet, packets), None]:
        for frame in decoder.decode(packet):
            kind = PictureType(frame.pict_type).name
            colours = frame.reformat(format="rgb24", interpolation=_CAREFUL)
            shown.append((np.asarray(colours.to_ndarray()), kind))
    return shown
