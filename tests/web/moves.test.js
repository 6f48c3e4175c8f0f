import assert from "node:assert/strict";
import { mock, test } from "node:test";
import { Coalescer } from "../../static/web/coalesce.js";
import { Moves, SEND_MS } from "../../static/web/moves.js";

function coalescer() {
  /** @type {number[]} */ const sent = [];
  /** @type {(() => void)[]} */ const timers = [];
  const time = { now: 0 };
  const made = new Coalescer(
    (/** @type {number} */ value) => sent.push(value),
    40,
    () => time.now,
    (callback) => timers.push(callback),
  );
  return { made, sent, timers, time };
}

test("the first goes at once, the newest of the others after the interval", () => {
  const { made, sent, timers, time } = coalescer();
  for (const value of [1, 2, 3]) made.offer(value);
  assert.deepEqual(sent, [1]);
  assert.equal(timers.length, 1);
  time.now = 40;
  timers[0]();
  assert.deepEqual(sent, [1, 3]);
});

test("what was flushed is not sent again", () => {
  const { made, sent, timers } = coalescer();
  made.offer(1);
  made.offer(2);
  made.flush();
  timers[0]();
  assert.deepEqual(sent, [1, 2]);
});

test("a gesture ends with its last place, said to be done", () => {
  mock.timers.enable({ apis: ["setTimeout"] });
  /** @type {import("../../static/web/moves.js").Move[]} */ const sent = [];
  const moves = new Moves((move) => sent.push(move));
  moves.begin();
  for (const x of [1, 2, 3]) moves.put([x], [0]);
  moves.end();
  assert.deepEqual(
    sent.map(({ to, done }) => [to[0], done]),
    [
      [1, false],
      [3, true],
    ],
  );
  moves.begin();
  moves.put([4], [0]);
  mock.timers.tick(SEND_MS);
  moves.end();
  assert.equal(sent.at(-1)?.to[0], 4);
  assert.ok(new Set(sent.map(({ gesture }) => gesture)).size === 2);
  const numbers = sent.map(({ number }) => number);
  assert.deepEqual(
    numbers,
    [...numbers].sort((a, b) => a - b),
  );
  mock.timers.reset();
});

test("the server's word counts once it has heard the last move", () => {
  const moves = new Moves(() => {});
  assert.ok(moves.accepts(null));
  moves.begin();
  moves.put([1], [0]);
  assert.ok(!moves.accepts(moves.number), "not while it is in the hand");
  moves.end();
  assert.ok(!moves.accepts(moves.number - 1));
  assert.ok(!moves.accepts(null));
  assert.ok(moves.accepts(moves.number));
});

test("keys that follow each other fast are one gesture", () => {
  mock.timers.enable({ apis: ["setTimeout"] });
  /** @type {import("../../static/web/moves.js").Move[]} */ const sent = [];
  const moves = new Moves((move) => sent.push(move));
  for (const x of [1, 2]) {
    moves.keyed();
    moves.put([x], [0]);
    mock.timers.tick(100);
  }
  mock.timers.tick(1000);
  assert.equal(new Set(sent.map(({ gesture }) => gesture)).size, 1);
  assert.deepEqual([sent.at(-1)?.to, sent.at(-1)?.done], [[2], true]);
  mock.timers.reset();
});
