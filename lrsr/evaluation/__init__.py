"""How sure is the answer? ROC curves, AUC with DeLong's interval, biometric error rates."""

from lrsr.evaluation.delong import compare_aucs, estimate_auc, measure_auc
from lrsr.evaluation.quality import psnr_y
from lrsr.evaluation.rates import cmc, d_prime, equal_error_rate, fnmr_at_fmr
from lrsr.evaluation.roc import band, trace_roc
from lrsr.evaluation.scores import CosineScores, Scores
from lrsr.evaluation.subjects import bootstrap_aucs, jackknife_auc
from lrsr.evaluation.summary import summarise

__all__ = [
    "CosineScores",
    "Scores",
    "band",
    "bootstrap_aucs",
    "cmc",
    "compare_aucs",
    "d_prime",
    "equal_error_rate",
    "estimate_auc",
    "fnmr_at_fmr",
    "jackknife_auc",
    "measure_auc",
    "psnr_y",
    "summarise",
    "trace_roc",
]
