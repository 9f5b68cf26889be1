"""How sure is the answer? ROC curves, AUC with DeLong's interval, biometric error rates."""
