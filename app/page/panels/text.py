"""Text that may hold anything: the names of files, motions and joints are anyone's.

viser's markdown renders raw HTML, and embeds the images that it names; nothing but fixed text and
numbers goes into it. Everything else is written here.
"""

from __future__ import annotations

from html import escape

import viser

TEXT_STYLE = "font-size:0.875em;line-height:1.35;padding:0.15em 0.75em;overflow-wrap:anywhere"

NAME_STYLE = "text-align:left;font-weight:400;white-space:nowrap"
CELL_STYLE = (
    "text-align:right;font-variant-numeric:tabular-nums;padding-left:0.6em;max-width:6em;"
    "overflow:hidden;text-overflow:ellipsis;white-space:nowrap"
)


def text_lines(*lines: str) -> str:
    """HTML of one paragraph a line that is not empty; whatever stands in them is text."""
    return "".join(f'<div style="{TEXT_STYLE}">{escape(line)}</div>' for line in lines if line)


def paragraphs(head: str, *texts: str) -> str:
    """HTML of a heading and paragraphs, the last of them in bold; all of it is text."""
    *before, last = (escape(text) for text in texts)
    body = "".join(f'<p style="margin:0.35em 0">{text}</p>' for text in before)
    return (
        f'<div style="{TEXT_STYLE}"><div style="opacity:0.7">{escape(head)}</div>{body}'
        f'<p style="margin:0.35em 0;font-weight:650">{last}</p></div>'
    )


def table(rows: list[list[str]]) -> str:
    """HTML of rows of cells, the first row and column of headings; all of it is text."""
    if not rows:
        return ""
    head, *body = ([escape(cell) for cell in row] for row in rows)
    columns = "".join(f'<th scope="col" style="{CELL_STYLE}">{cell}</th>' for cell in head)
    lines = "".join(
        f'<tr><th scope="row" style="{NAME_STYLE}">{name}</th>'
        + "".join(f'<td style="{CELL_STYLE}">{cell}</td>' for cell in cells)
        + "</tr>"
        for name, *cells in body
    )
    return (
        f'<div style="{TEXT_STYLE}"><table style="width:100%;border-spacing:0">'
        f"<tr>{columns}</tr>{lines}</table></div>"
    )


def write(html: viser.GuiHtmlHandle, content: str) -> None:
    """Write what does not stand there already."""
    if html.content != content:
        html.content = content
