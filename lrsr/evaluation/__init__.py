"""How sure is the answer? ROC curves, AUC with DeLong's interval, biometric error rates."""

from lrsr.evaluation.delong import compare_aucs, estimate_auc
from lrsr.evaluation.quality import psnr_y, ssim_y
from lrsr.evaluation.scores import CosineScores, Scores
from lrsr.evaluation.summary import summarise

__all__ = [
    "CosineScores",
    "Scores",
    "compare_aucs",
    "estimate_auc",
    "psnr_y",
    "ssim_y",
    "summarise",
]
