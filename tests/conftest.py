"""Tests run on several cores at once: each worker then keeps to its own."""

import os

if "PYTEST_XDIST_WORKER" in os.environ:  # before torch is imported
    os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ["LRSR_MODELS"] = "/nowhere"  # not what its user has pulled
