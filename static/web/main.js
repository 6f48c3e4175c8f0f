/** Everything together: what the server shows goes to its part, what a person does goes to the server. */

import { callAgainWhileSeen, canvasFrame, listen, missing, onTurn, send } from "./bridge.js";
import { spaceToggles } from "./keys.js";
import { LandscapeBoard } from "./landscape.js";
import { Layout } from "./layout.js";
import { MapBoard } from "./map.js";
import { element, isDark, onSchemeChange } from "./page.js";
import { Playback } from "./playback.js";
import { Presence } from "./presence.js";
import { Robots } from "./robots.js";
import { Steps } from "./steps.js";
import { installStyle } from "./style.js";
import { TimeBar } from "./timebar.js";

/** @typedef {import("./messages.js").Asked} Asked */
/** @typedef {import("./messages.js").Shown} Shown */
/** @typedef {{ [Kind in keyof Shown]: (shown: Shown[Kind]) => void }} Handlers */

const SLOTS = [0, 1]; // pairs of boards
const RESIZE_MS = 300;
const LOOK_MS = 400; // a camera that was let go swings out in less
const DOCUMENT = "rnnpb.document"; // in the tab's own storage

class Part {
  constructor() {
    installStyle(isDark, onSchemeChange);
    const ask = (/** @type {Asked} */ asked) => send(asked);
    this.robots = new Robots();
    const looked = () => this.looked();
    // Of two models side by side the second pair is filled, too.
    this.maps = SLOTS.map((slot) => new MapBoard(ask, looked, slot));
    this.landscapes = SLOTS.map((slot) => new LandscapeBoard(ask, looked, slot));
    this.map = this.maps[0];
    this.landscape = this.landscapes[0];
    this.playback = new Playback(this.robots, ask, (now) => {
      this.timebar?.refresh(now);
      const frame = this.playback?.clock.frame ?? 0;
      for (const map of this.maps) map.atFrame(frame);
      this.steps?.atFrame(frame);
    });
    this.timebar = new TimeBar(this.playback, ask);
    this.steps = new Steps(ask);
    this.presence = new Presence(ask);
    const boards = SLOTS.flatMap((slot) => [this.maps[slot], this.landscapes[slot]]);
    this.layout = new Layout(boards, this.timebar, [this.steps], {
      ask,
      looked,
      fitted: () => this.fitted(),
    });
    onTurn(() => {
      this.turned = true;
      looked();
    });
    callAgainWhileSeen();
    this.played = false;
    spaceToggles(() => this.playback.toggle(), this.timebar.play);
    listen((kind, body) => this.hear(kind, body));
  }

  /** @returns {Handlers} */
  get handlers() {
    const { maps, landscapes, playback, timebar, robots, layout, steps } = this;
    return {
      RobotsShown: (shown) => robots.show(shown),
      MotionShown: (shown) => {
        playback.showMotion(shown);
        timebar.showMotion(shown);
      },
      PlaybackShown: (shown) => {
        this.played = true;
        playback.show(shown);
      },
      MapShown: (shown) => {
        maps[shown.slot].show(shown);
        landscapes[shown.slot].showMap(shown);
        layout.showPairs(shown.pairs);
        steps.showPairs(shown.pairs);
      },
      PuckShown: (shown) => {
        maps[shown.slot].showPuck(shown);
        landscapes[shown.slot].showPuck(shown);
      },
      LandscapeShown: (shown) => landscapes[shown.slot].show(shown),
      CloudShown: (shown) => maps[shown.slot].showCloud(shown),
      PathShown: (shown) => {
        maps[shown.slot].showPath(shown);
        landscapes[shown.slot].showPath(shown);
      },
      WaysShown: (shown) => {
        maps[shown.slot].showWays(shown);
        steps.show(shown);
      },
      CurvesShown: (shown) => timebar.showCurves(shown),
      LookShown: (shown) => {
        maps[0].zoomTo(shown.map);
        maps[1].zoomTo(shown.map_2);
        landscapes[0].zoomTo(shown.landscape);
        landscapes[1].zoomTo(shown.landscape_2);
        layout.openTab(shown.tab);
      },
      DocumentShown: ({ text }) => keep(text),
      PresenceShown: (shown) => this.presence.show(shown),
    };
  }

  /** A message that cannot be shown costs that message. @param {string} kind @param {unknown} body */
  hear(kind, body) {
    const handler = this.handlers[/** @type {keyof Shown} */ (kind)];
    try {
      if (!handler) throw new Error("unknown");
      /** @type {(body: unknown) => void} */ (handler)(body);
    } catch (error) {
      console.error(`rnnpb-explorer: ${kind} cannot be shown:`, error);
      this.layout.say(`The page cannot show ${kind}: ${error}`, "problem");
    }
  }

  /** The first word on every connection; the server answers with everything. */
  hello() {
    const { playing, frame, speed, loop } = this.playback.clock;
    this.playback.number = null;
    this.greeted = true;
    clearTimeout(this.resting);
    this.told = JSON.stringify(this.size());
    send({
      type: "Hello",
      document: kept(),
      ...this.size(),
      dark: matchMedia("(prefers-color-scheme: dark)").matches,
      playback: this.played ? { playing, frame, speed, loop } : null,
      ...this.presence.hello(),
    });
  }

  size() {
    const box = canvasFrame()?.getBoundingClientRect();
    return {
      width: Math.round(box?.width ?? innerWidth),
      height: Math.round(box?.height ?? innerHeight),
      ratio: devicePixelRatio,
      page_width: innerWidth,
      page_height: innerHeight,
    };
  }

  /** The server frames the robot anew once the canvas has kept another size for a while. */
  fitted() {
    const box = canvasFrame()?.getBoundingClientRect();
    if (box) this.presence.standOver(box);
    const size = JSON.stringify(this.size());
    if (size === this.told) return;
    this.told = size;
    clearTimeout(this.resting);
    this.resting = setTimeout(() => {
      if (this.greeted) send({ type: "Resized", ...this.size() });
    }, RESIZE_MS);
  }

  /** The server keeps where a person looks, once that has rested. */
  looked() {
    clearTimeout(this.looking);
    this.looking = setTimeout(() => {
      if (!this.greeted) return;
      const [map, map_2] = this.maps.map(({ zoom }) => zoom);
      const [landscape, landscape_2] = this.landscapes.map(({ zoom }) => zoom);
      const { turned } = this;
      const { tab } = this.layout;
      send({ type: "Looked", map, landscape, map_2, landscape_2, tab, turned });
      this.turned = false;
    }, LOOK_MS);
  }

  turned = false;
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  looking = undefined;

  told = "";
  greeted = false;

  /** @type {ReturnType<typeof setTimeout> | undefined} */
  resting = undefined;
}

/** @param {string} text */
function keep(text) {
  try {
    sessionStorage.setItem(DOCUMENT, text);
  } catch (error) {
    console.warn("rnnpb-explorer: this tab cannot keep its state over a reload:", error);
  }
}

function kept() {
  try {
    return sessionStorage.getItem(DOCUMENT);
  } catch {
    return null; // storage is switched off
  }
}

/**
 * Runs on every connection: the first time it makes everything, later it says hello again; a server
 * with another version of it gets a fresh page.
 * @param {string} version
 */
export function main(version) {
  const page = /** @type {{ rnnpb?: { version: string, part: Part } }} */ (
    /** @type {unknown} */ (window)
  );
  if (page.rnnpb && page.rnnpb.version !== version) {
    location.reload();
    return;
  }
  const problem = missing();
  if (problem) {
    console.error(`rnnpb-explorer: ${problem}`);
    document.body.append(
      element("p", {
        role: "alert",
        text: problem,
        style:
          "position:fixed;inset:0 0 auto;z-index:99;margin:0;padding:8px;background:#fff1e0;color:#a84300",
      }),
    );
    send({ type: "Broken", reason: problem });
    return;
  }
  page.rnnpb ??= { version, part: new Part() };
  page.rnnpb.part.hello();
}
