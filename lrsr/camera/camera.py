"""What file does the camera make of the light on its film? One chain of steps, as a module."""

import torch
from torch import nn

from lrsr.camera.codec import compression as preset
from lrsr.camera.codec import jpeg, jpeg_differentiable
from lrsr.camera.encoding import encode
from lrsr.camera.exposure import expose
from lrsr.errors import InputError

CODECS = ("true", "differentiable")


class Camera(nn.Module):
    """Exposure, sRGB curve, 8 bits, JPEG: from linear light to the pixels of a stored file.

    The exposure is that of an incident-light meter (:mod:`lrsr.camera.exposure`): it depends on
    the lighting alone. Nothing in the chain is random and no image sees another one of its batch.

    Args:
        compression: "none", "small" or "heavy" (:data:`lrsr.camera.codec.COMPRESSIONS`). The
            result has 8 bits with "none" too.
        exposure_ev: Stops over (+) or under (-) the meter's reading.
        codec: "true": OpenCV's JPEG, for evaluation; "differentiable": gradients reach the light.
        name: Of the preset; goes into manifests and reports.

    Raises:
        InputError: Unknown compression or codec.

    Example:
        >>> white_sphere = torch.ones(1, 3, 8, 8)
        >>> Camera()(white_sphere, torch.ones(1)).mul(255).unique().tolist()
        [243.0]
    """

    def __init__(
        self,
        compression: str = "none",
        exposure_ev: float = 0.0,
        codec: str = "true",
        name: str = "reference",
    ) -> None:
        super().__init__()
        if codec not in CODECS:
            raise InputError(f"codec {codec!r}: choose one of {', '.join(CODECS)}")
        self.quality = preset(compression).quality
        self.compression = compression
        self.exposure_ev = float(exposure_ev)
        self.codec = codec
        self.name = name

    def forward(self, linear: torch.Tensor, metered: torch.Tensor) -> torch.Tensor:
        """Take the picture.

        Args:
            linear: ``(B, 3, H, W)`` float32, scene-referred linear light, any H and W >= 1.
            metered: ``(B,)``, reading of the incident-light meter, > 0.

        Returns:
            srgb ``(B, 3, H, W)`` float32, [0, 1], multiples of 1/255.

        Raises:
            ImageContractError: The images break the contract, or ``metered`` does not fit them.
            NonFiniteError: A NaN or an infinity in the images.
        """
        trained_through = self.codec == "differentiable"
        srgb = encode(expose(linear, metered, self.exposure_ev), differentiable=trained_through)
        if self.quality is None:
            return srgb
        return (jpeg_differentiable if trained_through else jpeg)(srgb, self.quality)

    def compressing(self, compression: str) -> "Camera":
        """Return the same camera with another compression.

        Raises:
            InputError: Unknown compression.
        """
        return Camera(compression, self.exposure_ev, self.codec, self.name)

    def extra_repr(self) -> str:
        """Show the settings when the module is printed."""
        return (
            f"compression={self.compression!r}, exposure_ev={self.exposure_ev:g}, "
            f"codec={self.codec!r}, name={self.name!r}"
        )
