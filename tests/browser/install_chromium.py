"""Make sure that there is a Chromium for the browser tests (`make test` runs this)."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys

from rnnpb_explorer.app.commands.photograph import find_chromium


def main() -> int:
    if find_chromium() or playwright_has_chromium():
        return 0
    print("no Chromium or Chrome here; installing one for the browser tests", flush=True)
    if shutil.which("apt-get"):
        environment = {**os.environ, "DEBIAN_FRONTEND": "noninteractive"}
        for arguments in (["update"], ["install", "-y", "--no-install-recommends", "chromium"]):
            run([*as_root(), "apt-get", "-qq", *arguments], environment)
    if find_chromium() is None:
        run([sys.executable, "-m", "playwright", "install", "chromium"])
    if find_chromium() or playwright_has_chromium():
        return 0
    print("no Chromium could be installed; set RNNPB_CHROMIUM to one", file=sys.stderr)
    return 1


def playwright_has_chromium() -> bool:
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        return os.path.isfile(playwright.chromium.executable_path)


def as_root() -> list[str]:
    return [] if os.geteuid() == 0 else ["sudo", "-n"]


def run(command: list[str], environment: dict[str, str] | None = None) -> None:
    """Run a step whose failure the next one may still mend."""
    try:
        subprocess.run(command, env=environment, stdin=subprocess.DEVNULL, check=False)
    except FileNotFoundError as error:
        print(error, file=sys.stderr)


if __name__ == "__main__":
    sys.exit(main())
