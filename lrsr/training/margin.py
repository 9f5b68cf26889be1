"""What pulls the faces of one person together and other people apart? An angle, with a margin."""

import math

import torch
import torch.nn.functional as F
from torch import nn


class AngularMargin(nn.Module):
    """Additive angular margin: ArcFace (Deng et al. 2019, arXiv:1801.07698, equation 3).

    The score of person j is s cos θ_j, θ_j the angle to that person's direction, but s cos(θ_y + m)
    for the right person y. Where θ_y + m would pass π, where the cosine would rise again, it is
    s (cos θ_y - m sin m), as in the authors' code.

    Args:
        dimension: Of the embeddings.
        people: How many directions.
        scale: s, > 0.
        margin: m, radians, 0 to π/2.
    """

    def __init__(self, dimension: int, people: int, *, scale: float, margin: float) -> None:
        super().__init__()
        self.scale = scale
        self.margin = margin
        self.directions = nn.Parameter(torch.empty(people, dimension))
        nn.init.normal_(self.directions, std=0.01)

    def cosines(self, embeddings: torch.Tensor) -> torch.Tensor:
        """Return cos θ, ``(B, people)``, of embeddings ``(B, dimension)`` of any length."""
        return F.linear(F.normalize(embeddings.float()), F.normalize(self.directions.float()))

    def forward(self, embeddings: torch.Tensor, people: torch.Tensor) -> torch.Tensor:
        """Return the logits ``(B, people)`` for softmax cross-entropy.

        Args:
            embeddings: ``(B, dimension)``, any length.
            people: ``(B,)`` int64, who each one is.

        Example:
            >>> head = AngularMargin(2, 2, scale=10.0, margin=0.5)
            >>> with torch.no_grad():
            ...     _ = head.directions.copy_(torch.eye(2))
            ...     logits = head(torch.tensor([[3.0, 4.0]]), torch.tensor([0]))
            >>> [round(value, 3) for value in logits[0].tolist()]  # 10 cos(arccos 0.6 + 0.5), 8
            [1.43, 8.0]
        """
        cosine = self.cosines(embeddings)
        right = cosine.gather(1, people[:, None])
        sine = (1 - right.square()).clamp_min(1e-7).sqrt()
        moved = right * math.cos(self.margin) - sine * math.sin(self.margin)
        beyond = right <= -math.cos(self.margin)  # θ + m >= π
        moved = torch.where(beyond, right - self.margin * math.sin(self.margin), moved)
        return self.scale * cosine.scatter(1, people[:, None], moved.to(cosine.dtype))
