"""How little a glass spreads colours, as catalogues print it."""

from lrsr.rendering.glass import D_LINE_NM, refractive_index

F_LINE_NM = 486.1327
"""Blue line of hydrogen."""

C_LINE_NM = 656.2725
"""Red line of hydrogen."""


def abbe_number(glass: str) -> float:
    """Return V_d = (n_d - 1) / (n_F - n_C)."""
    n_d, n_f, n_c = refractive_index(glass, [D_LINE_NM, F_LINE_NM, C_LINE_NM])
    return float((n_d - 1) / (n_f - n_c))
