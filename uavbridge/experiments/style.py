"""How the experiments' pictures look: colours that stay apart for colour-blind eyes, plain axes."""

from __future__ import annotations

from matplotlib.axes import Axes

INK, FAINT = "#24303c", "#8b97a3"
RED, PURPLE, GREEN, ORANGE, INDIGO = "#c8402f", "#8e4fa8", "#117733", "#e08a1e", "#332288"


def plain(axes: Axes) -> None:
    """No box, a faint grid behind."""
    axes.spines[["top", "right"]].set_visible(False)
    axes.spines[["left", "bottom"]].set_color(FAINT)
    axes.tick_params(colors=INK, length=3, width=0.8)
    axes.grid(visible=True, color="#e6eaee", linewidth=0.8)
    axes.set_axisbelow(True)
