"""The modules of `static/web` as one script that a page can run.

They are plain ES modules, for node's tests and the type checker; here each becomes a function that
returns what it exports. No bundler: `import { a, b } from "./x.js"` and `export` before a
declaration are all that they may use, which is checked.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable
from functools import lru_cache
from importlib import resources

MAIN = "main"
_IMPORT = re.compile(r'^import \{([^}]*)\} from "\./(\w+)\.js";$', re.MULTILINE)
_EXPORT = re.compile(r"^export ((?:const|class|function) (\w+))", re.MULTILINE)
_OTHER = re.compile(r"^(?:import|export)\b.*", re.MULTILINE)


@lru_cache(maxsize=1)
def script() -> str:
    """The script: it starts `main(version)`, with a version of its own for each content."""
    folder = resources.files("rnnpb_explorer.static").joinpath("web")
    modules: dict[str, str] = {}
    _add(MAIN, lambda name: folder.joinpath(f"{name}.js").read_text("utf-8"), modules)
    body = "\n".join(modules.values())
    version = hashlib.sha256(body.encode()).hexdigest()[:12]
    return (
        f'"use strict";\ntry {{\n{body}\n_{MAIN}.main("{version}");\n}} catch (error) {{\n'
        'console.error("rnnpb-explorer: the boards do not start:", error);\n'
        "document.body.append(`The boards do not start: ${error}`);\n}\n"
        "//# sourceURL=rnnpb-explorer.js\n"
    )


def _add(name: str, read: Callable[[str], str], modules: dict[str, str]) -> None:
    """A module after all that it imports."""
    if name in modules:
        return
    source = read(name)
    for match in _IMPORT.finditer(source):
        _add(match[2], read, modules)
    modules[name] = wrapped(name, source)


def wrapped(name: str, source: str) -> str:
    """A module as an expression of its own scope: `const _name = (() => { ... })();`.

    Raises:
        ValueError: it imports or exports in another way than described above.
    """
    renamed = next((match[0] for match in _IMPORT.finditer(source) if " as " in match[1]), None)
    if renamed:
        raise ValueError(f"{name}.js: cannot join {renamed!r}")
    exported = ", ".join(match[2] for match in _EXPORT.finditer(source))
    source = _IMPORT.sub(lambda match: f"const {{{match[1]}}} = _{match[2]};", source)
    source = _EXPORT.sub(r"\1", source)
    if other := _OTHER.search(source):
        raise ValueError(f"{name}.js: cannot join {other[0]!r}")
    return f"const _{name} = (() => {{\n{source}\nreturn {{ {exported} }};\n}})();"
