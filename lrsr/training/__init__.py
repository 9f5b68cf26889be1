"""One way in which every network is trained: :func:`lrsr.training.run.train`."""
