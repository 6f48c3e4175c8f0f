"""Pages without a browser, in a process of their own: they open, and drag, play or follow.

    python benchmarks/page_clients.py URL SECONDS MOTION DRAGGING PLAYING FOLLOWING

MOTION is the index of the one that the pages open with; the next three are numbers of pages. Those
that follow do what the first of those does that drag. Waits for a line before it begins.

Prints a line when all are ready, then one of JSON: of each page that drags the milliseconds from
each move of the hand to the motion that it led to, and its landscapes, of which a hand that moves
on lets only the coarse ones come; how many messages each of the others got.

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

    def __init__(self, circle: Circle | None = None, follow: str | None = None) -> None:
        self.circle, self.follow = circle, follow
        self.sent: dict[int, float] = {}  # when the hand was last at a point
        self.latencies: list[float] = []
        self.messages = self.landscapes = 0
        self.code = ""  # of what this page presents or follows
        self.ready, self.presence = asyncio.Event(), asyncio.Event()

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
            self.messages = self.landscapes = 0
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
                                    dark=False, playback=None,
                                    follow=self.follow)  # fmt: skip
                elif message["type"] == "RnnpbShown":
                    self._shown(message["kind"], message["body"], now)

    def _shown(self, kind: str, body: dict[str, Any], now: float) -> None:
        if kind == "LandscapeShown":
            self.landscapes += 1
            if body["complete"]:
                self.ready.set()
        if kind == "PresenceShown":
            self.code = body["code"]
            self.presence.set()
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

    async def present(self) -> str:
        """The code for those who follow."""
        await self.ready.wait()
        self.presence.clear()
        await self._ask(type="Present", on=True)
        await self.presence.wait()
        return self.code


async def main(
    url: str, seconds: float, motion: int, dragging: int, playing: int, following: int
) -> None:
    circle = Circle(motion) if dragging else None
    begin = asyncio.Event()
    drags = [Page(circle) for _ in range(dragging)]
    others = [Page() for _ in range(playing)]
    running = [asyncio.create_task(page.run(url, begin, seconds)) for page in (*drags, *others)]
    if following:
        code = await drags[0].present()
        late = [Page(follow=code) for _ in range(following)]
        running += [asyncio.create_task(page.run(url, begin, seconds)) for page in late]
        others += late
    ready = asyncio.gather(*(page.ready.wait() for page in (*drags, *others)))
    await asyncio.wait([ready, *running], return_when=asyncio.FIRST_COMPLETED)
    if not ready.done():
        await asyncio.gather(*running)  # one that broke off says why
    print("ready", flush=True)
    await asyncio.to_thread(sys.stdin.readline)
    begin.set()
    await asyncio.gather(*running)
    found = {
        "latencies": [page.latencies for page in drags],
        "landscapes": [page.landscapes for page in drags],
        "messages": [page.messages for page in others],
    }
    print(json.dumps(found), flush=True)


if __name__ == "__main__":
    torch.set_num_threads(1)
    _, url_, seconds_, *numbers = sys.argv
    asyncio.run(main(url_, float(seconds_), *map(int, numbers)))
