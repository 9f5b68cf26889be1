"""How sure is the answer? ROC curves, AUC with DeLong's interval, biometric error rates."""

from lrsr.evaluation.biometrics import (
    CmcCurve,
    EqualErrorRate,
    OperatingPoint,
    cmc,
    d_prime,
    equal_error_rate,
    fnmr_at_fmr,
    rank_probes,
)
from lrsr.evaluation.delong import (
    AucComparison,
    AucEstimate,
    compare_aucs,
    estimate_auc,
    measure_auc,
)
from lrsr.evaluation.quality import psnr_y, ssim_y
from lrsr.evaluation.roc import DetPoints, RocBand, RocCurve, band, det_points, trace_roc
from lrsr.evaluation.streaming import count_cosines, estimate_auc_of_embeddings
from lrsr.evaluation.subjects import (
    BootstrapInterval,
    SubjectBootstrap,
    bootstrap_aucs,
    jackknife_auc,
)

__all__ = [
    "AucComparison",
    "AucEstimate",
    "BootstrapInterval",
    "CmcCurve",
    "DetPoints",
    "EqualErrorRate",
    "OperatingPoint",
    "RocBand",
    "RocCurve",
    "SubjectBootstrap",
    "band",
    "bootstrap_aucs",
    "cmc",
    "compare_aucs",
    "count_cosines",
    "d_prime",
    "det_points",
    "equal_error_rate",
    "estimate_auc",
    "estimate_auc_of_embeddings",
    "fnmr_at_fmr",
    "jackknife_auc",
    "measure_auc",
    "psnr_y",
    "rank_probes",
    "ssim_y",
    "trace_roc",
]
