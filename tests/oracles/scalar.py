"""What the slow variant shows; it must be the only one of its process.

``python -m oracles.scalar OUT.npz`` with LRSR_VARIANT=scalar_rgb; the pictures are judged by the
tests of ``lrsr.rendering``.
"""

import sys
from typing import Any

import drjit
import numpy as np
from oracles.heads import stand_in

import lrsr.rendering

ASK: dict[str, Any] = {"lighting": "side", "ipd_px": 4, "samples_per_pixel": 16}

if __name__ == "__main__":
    threads = drjit.thread_count()
    pictures = {
        lens: lrsr.rendering.render(stand_in(0), lens=lens, **ASK).image.numpy()
        for lens in ("pinhole", "single")
    }
    assert drjit.thread_count() == threads
    np.savez(sys.argv[1], **pictures)
