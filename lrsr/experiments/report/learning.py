"""What does learning look like? A figure by epoch, a curve a run."""

from collections.abc import Mapping, Sequence

from matplotlib import rc_context
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from lrsr.pages import DPI, STYLE, line_style, png_bytes


def draw_learning(curves: Mapping[str, Sequence[float]], quantity: str) -> bytes:
    """Draw values by epoch, with a dot at each highest.

    Args:
        curves: By label, at least one, one value an epoch.
        quantity: What the axis says.

    Returns:
        A PNG.
    """
    with rc_context(STYLE):
        figure = Figure(figsize=(7.2, 3.6), dpi=DPI, layout="constrained")
        axes = figure.subplots()
        for number, (label, values) in enumerate(curves.items()):
            style, epochs = line_style(number), range(1, len(values) + 1)
            axes.plot(epochs, values, label=label, **style)
            best = max(epochs, key=lambda epoch: values[epoch - 1])
            axes.plot(best, values[best - 1], "o", color=style["color"], markersize=4)
        axes.set(xlabel="Epoch", ylabel=quantity)
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        axes.grid(visible=True)
        axes.legend(loc="lower right", handlelength=3)
        return png_bytes(figure)
