"""The thesis's Figure 9 as SVG and as a table: which node's iteration was computed, with one column per situation."""

from __future__ import annotations

from html import escape

from .plot import COLOURS, STYLE

CELL, ROW, LEFT, TOP, GAP = 74, 19, 12, 62, 14


def svg(situations: list[dict]) -> str:
    rows = len(situations[0]["turns"])
    height = TOP + ROW * rows + 26 + 15 * len(situations)
    width = 2 * LEFT + (CELL + GAP) * len(situations)
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" '
             'role="img" aria-label="Whose iteration is computed, in seven situations">', STYLE,
             '<style> .cell { font-size: 11px; fill: #fff } </style>',
             f'<text class="title" x="{LEFT}" y="17">Node and its iteration, one turn a row (thesis, Figure 9)</text>']
    for number, situation in enumerate(situations):
        x = LEFT + number * (CELL + GAP)
        nodes = len(situation["begin"])
        parts += [f'<text class="title" x="{x}" y="38">{number + 1}</text>',
                  f'<text x="{x}" y="53">{nodes} nodes</text>']
        for row, (node, iteration) in enumerate(situation["turns"]):
            y = TOP + row * ROW
            parts.append(f'<rect x="{x}" y="{y}" width="{CELL}" height="{ROW - 2}" rx="2" fill="{COLOURS[node - 1]}"/>'
                         f'<text class="cell" style="fill:#fff" x="{x + 6}" y="{y + 13}">{node}</text>'
                         f'<text class="cell" style="fill:#fff" text-anchor="end" x="{x + CELL - 6}" y="{y + 13}">{iteration}</text>')
    for number, situation in enumerate(situations):
        shares = ", ".join(f"{100 * share:.0f}%" for share in situation["shares"])
        parts.append(f'<text x="{LEFT}" y="{TOP + ROW * rows + 22 + 15 * number}">'
                     f'{number + 1}: {escape(situation["what"].split(": ", 1)[1])}; shares of the turns {shares}</text>')
    return "\n".join([*parts, "</svg>", ""])


def table(situations: list[dict]) -> str:
    """Returns the table in Markdown."""
    lines = ["| | " + " | ".join(str(i + 1) for i in range(len(situations))) + " |", "|---" * (len(situations) + 1) + "|"]
    for row in range(len(situations[0]["turns"])):
        lines.append(f"| {row + 1} | " + " | ".join("{}: {}".format(*s["turns"][row]) for s in situations) + " |")
    return "\n".join(lines) + "\n"
