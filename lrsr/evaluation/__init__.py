"""How sure is the answer? ROC curves, AUC with DeLong's interval, biometric error rates."""

from lrsr.evaluation.delong import (
    AucComparison,
    AucEstimate,
    compare_aucs,
    estimate_auc,
    measure_auc,
)
from lrsr.evaluation.quality import psnr_y, ssim_y

__all__ = [
    "AucComparison",
    "AucEstimate",
    "compare_aucs",
    "estimate_auc",
    "measure_auc",
    "psnr_y",
    "ssim_y",
]
