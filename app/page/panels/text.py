"""Text that may hold anything: the names of files, motions and joints are anyone's.

viser's markdown renders raw HTML, and embeds the images that it names; nothing but fixed text and
numbers goes into it. Everything else is written here.
"""

from __future__ import annotations

from html import escape

import viser

TEXT_STYLE = "font-size:0.875em;line-height:1.35;padding:0.15em 0.75em;overflow-wrap:anywhere"


def text_lines(*lines: str) -> str:
    """HTML of one paragraph a line that is not empty; whatever stands in them is text."""
    return "".join(f'<div style="{TEXT_STYLE}">{escape(line)}</div>' for line in lines if line)


def write(html: viser.GuiHtmlHandle, content: str) -> None:
    """Write what does not stand there already."""
    if html.content != content:
        html.content = content
