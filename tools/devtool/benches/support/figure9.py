"""The thesis's Figure 9 as SVG and as a table: which node's iteration was computed, with one column per situation."""

from __future__ import annotations

import matplotlib
from matplotlib.figure import Figure

from .plot import COLOURS, STYLE, text_of


@matplotlib.rc_context(STYLE)
def svg(situations: list[dict]) -> str:
    turns = list(zip(*(situation["turns"] for situation in situations)))
    shares = "\n".join(f"{number}: {one['what'].split(': ', 1)[1]}; shares of the turns {', '.join(f'{share:.0%}' for share in one['shares'])}"
                       for number, one in enumerate(situations, 1))
    height = 0.22 * (len(turns) + 1) + 0.15 * len(situations) + 0.6
    figure = Figure(figsize=(1.2 * len(situations), height))
    axes = figure.subplots(gridspec_kw={"left": 0.01, "right": 0.99, "top": 1 - 0.4 / height, "bottom": (0.15 * len(situations) + 0.2) / height})
    axes.axis("off")
    axes.set_title("Node and its iteration, one turn a row (thesis, Figure 9)")
    table = axes.table([[f"{node}: {iteration}" for node, iteration in row] for row in turns], bbox=(0, 0, 1, 1), cellLoc="center",
                       cellColours=[[COLOURS[node - 1] for node, _ in row] for row in turns],
                       colLabels=[f"{number} ({len(one['begin'])} nodes)" for number, one in enumerate(situations, 1)])
    for (row, _), cell in table.get_celld().items():
        cell.set(edgecolor="none", facecolor=cell.get_facecolor() if row else "none")
        if row:
            cell.set_text_props(color="white")
    figure.text(0.01, 0.08 / height, shares)
    return text_of(figure)


def table(situations: list[dict]) -> str:
    """Returns the table in Markdown."""
    lines = ["| | " + " | ".join(str(i + 1) for i in range(len(situations))) + " |", "|---" * (len(situations) + 1) + "|"]
    for row in range(len(situations[0]["turns"])):
        lines.append(f"| {row + 1} | " + " | ".join("{}: {}".format(*s["turns"][row]) for s in situations) + " |")
    return "\n".join(lines) + "\n"
