"""What the slow variant shows; it must be the only one of its process.

``python -m oracles.scalar OUT.npz`` with LRSR_VARIANT=scalar_rgb; the pictures are judged by the
tests of ``lrsr.rendering``.
"""

import sys
from typing import Any

import numpy as np
from fakes.scenes import Studio
from oracles.heads import stand_in

ASK: dict[str, Any] = {"lighting": "side", "ipd_px": 4, "samples_per_pixel": 16}

if __name__ == "__main__":
    import drjit  # not sooner: who imports it first, as doctests would, decides on the LLVM

    threads = drjit.thread_count()
    pictures = {
        lens: Studio().render(stand_in(0), lens=lens, shift_px=shift_px, **ASK).image.numpy()
        for lens, shift_px in (("pinhole", (0.9, -0.7)), ("single", (0.0, 0.0)))
    }
    assert drjit.thread_count() == threads
    np.savez(sys.argv[1], **pictures)
