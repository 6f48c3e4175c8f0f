"""Pages without a browser, in a process of their own: they open, and drag or play.

    python benchmarks/page_clients.py URL PAGES SECONDS MOTION|play

MOTION is the index of the one that the pages open with. Waits for a line before it begins.

Prints a line when all are ready, then one of JSON: the milliseconds from each
move of the hand to the motion that it led to, and how many messages each page got.

A move is told from the next by the motion itself: the moves go round a circle on the map, and the
first frames of the motions at its points are computed beforehand.
"""

from __future__ import annotations

import asyncio
import json
import sys
import time
from pathlib import Path
from typing import Any

import msgspec.msgpack
import numpy as np
import torch
import viser
from viser import _messages as wire
from websockets.asyncio.client import connect
from websockets.typing import Subprotocol

from rnnpb_explorer.core import load_checkpoint
from rnnpb_explorer.core.latent_map import LatentMap

sys.path.append(str(Path(__file__).parents[1] / "tests"))
from viser_wire import messages, shown_array

POINTS = 128  # on the circle; a hand that makes 20 moves a second comes round in six seconds
MOVE_SECONDS = 0.05
FRAMES = 40  # of a motion that tell it from the others
MODEL = "strong"
CAMERA: dict[str, Any] = {
    "wxyz": (0.5, 0.5, -0.5, -0.5),
    "position": (4.0, 0.0, 1.0),
    "fov": 0.5,
    "near": 0.01,
    "far": 1000.0,
    "image_height": 720,
    "image_width": 1280,
    "look_at": (0.0, 0.0, 1.0),
    "up_direction": (0.0, 0.0, 1.0),
}


class Circle:
    """Moves around a motion on the map, and the beginning of each one's motion."""

    def __init__(self, motion: int) -> None:
        model = load_checkpoint(MODEL)
        mu = model.mu.detach().numpy().astype(np.float64)
        latent_map = LatentMap.fit(mu)
        angles = np.linspace(0, 2 * np.pi, POINTS, endpoint=False)
        middle = latent_map.points[motion, :2]
        self.to = middle + 0.8 * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        pbs = np.stack([latent_map.move(mu[motion], (0, 1), to.tolist()) for to in self.to])
        with torch.inference_mode():
            motions = model.generate(torch.as_tensor(pbs, dtype=torch.float32), FRAMES)
        self.beginnings = motions.numpy().reshape(POINTS, -1)

    def point_of(self, angles: np.ndarray) -> int:
        """Which point's motion (T, J) this is."""
        apart = np.abs(self.beginnings - angles[:FRAMES].ravel()).max(axis=1)
        return int(apart.argmin())


class Page:
    """One page: says hello, moves its puck, takes what comes."""

    def __init__(self, circle: Circle | None) -> None:
        self.circle = circle
        self.sent: dict[int, float] = {}  # when the hand was last at a point
        self.latencies: list[float] = []
        self.messages = 0
        self.ready = asyncio.Event()

    async def run(self, url: str, begin: asyncio.Event, seconds: float) -> None:
        protocol = Subprotocol(f"viser-v{viser.__version__}")
        async with connect(
            url.replace("http", "ws", 1), subprotocols=[protocol], compression=None, max_size=None
        ) as socket:
            self.socket = socket
            # viser has no client before it knows where the camera is.
            await self._send(wire.ViewerCameraMessage(**CAMERA).as_serializable_dict())
            reading = asyncio.create_task(self._read())
            await begin.wait()
            self.messages = 0
            if self.circle is None:
                await asyncio.sleep(seconds)
            else:
                await self._drag(self.circle, seconds)
            reading.cancel()

    async def _read(self) -> None:
        async for raw in self.socket:
            now = time.perf_counter()
            assert isinstance(raw, bytes)
            for message in messages(raw):
                self.messages += 1
                if message["type"] == "RunJavascriptMessage":
                    await self._ask(type="Hello", document=None, width=640, height=480,
                                    page_width=1280, page_height=720, ratio=1.0,
                                    dark=False, playback=None)  # fmt: skip
                elif message["type"] == "RnnpbShown":
                    self._shown(message["kind"], message["body"], now)

    def _shown(self, kind: str, body: dict[str, Any], now: float) -> None:
        if kind == "LandscapeShown" and body["complete"]:
            self.ready.set()
        if kind == "MotionShown" and self.circle is not None and self.sent:
            sent = self.sent.pop(self.circle.point_of(shown_array(body["angles"])), None)
            if sent is not None:
                self.latencies.append(1e3 * (now - sent))

    async def _drag(self, circle: Circle, seconds: float) -> None:
        start = time.perf_counter()
        for move in range(int(seconds / MOVE_SECONDS)):
            await asyncio.sleep(max(start + move * MOVE_SECONDS - time.perf_counter(), 0))
            point = move % POINTS
            self.sent[point] = time.perf_counter()
            await self._ask(
                type="MoveOnMap",
                model=0,
                axes=[0, 1],
                to=circle.to[point].tolist(),
                gesture=1,
                number=move + 1,
                done=False,
            )
        await asyncio.sleep(1.0)  # for the last ones

    async def _ask(self, **fields: object) -> None:
        await self._send({"type": "RnnpbAsked", "payload": json.dumps(fields)})

    async def _send(self, message: dict[str, Any]) -> None:
        await self.socket.send(msgspec.msgpack.encode(message))


async def main(url: str, pages: int, seconds: float, motion: int | None) -> None:
    circle = None if motion is None else Circle(motion)
    begin = asyncio.Event()
    opened = [Page(circle) for _ in range(pages)]
    running = [asyncio.create_task(page.run(url, begin, seconds)) for page in opened]
    ready = asyncio.gather(*(page.ready.wait() for page in opened))
    await asyncio.wait([ready, *running], return_when=asyncio.FIRST_COMPLETED)
    if not ready.done():
        await asyncio.gather(*running)  # one that broke off says why
    print("ready", flush=True)
    await asyncio.to_thread(sys.stdin.readline)
    begin.set()
    await asyncio.gather(*running)
    print(
        json.dumps(
            {
                "latencies": [page.latencies for page in opened],
                "messages": [page.messages for page in opened],
            }
        ),
        flush=True,
    )


if __name__ == "__main__":
    torch.set_num_threads(1)
    _, url_, pages_, seconds_, motion_ = sys.argv
    asyncio.run(
        main(url_, int(pages_), float(seconds_), None if motion_ == "play" else int(motion_))
    )
