/**
 * The one file that knows the inner names of viser's page (1.1.1); `app/page/bridge.py` is the one
 * on the server's side. viser exposes them for its own tests: they are no promise, so what is
 * missing is said in one line.
 */

import { MESSAGE_TYPES } from "./messages.js";

/**
 * @typedef {object} Node3 a three.js object, as far as it is used here
 * @property {string} type
 * @property {Node3 | null} parent
 * @property {Node3[]} children
 * @property {{ set: (x: number, y: number, z: number, w: number) => void }} quaternion
 * @property {{ set: (x: number, y: number, z: number) => void }} position
 * @property {boolean} visible
 * @property {boolean} castShadow
 * @property {number} renderOrder
 * @property {Material3 | Material3[]} [material]
 * @property {(child: Node3) => void} add
 * @property {(child: Node3) => void} remove
 * @property {(recursive: boolean) => Node3} clone
 */
/**
 * @typedef {object} Material3
 * @property {boolean} transparent
 * @property {number} opacity
 * @property {boolean} depthWrite
 * @property {boolean} polygonOffset
 * @property {number} polygonOffsetFactor
 * @property {number} polygonOffsetUnits
 * @property {{ setRGB: (r: number, g: number, b: number, space: string) => void }} [color]
 * @property {() => Material3} clone
 * @property {() => void} dispose
 */
/**
 * @typedef {object} Mutable
 * @property {{ type: string }[]} messageQueue
 * @property {(message: { type: string, payload: string }) => void} sendMessage
 * @property {() => void} requestRender
 * @property {Record<string, Node3 | undefined>} nodeRefFromName
 * @property {HTMLCanvasElement | null} canvas
 */
/** @typedef {{ type: string, kind: string, body: unknown }} Shown */

const WAY_UP = 6; // parents of the canvas among which its frame is
export const PHONE = "(max-width: 36em)"; // viser's own breakpoint to a sheet at the bottom

/** @returns {Mutable} */
const mutable = () =>
  /** @type {{ __viserMutable?: Mutable }} */ (window).__viserMutable ?? /** @type {never} */ ({});

/** What is missing of viser's inner names, in one line; null when all are there. */
export function missing() {
  const { messageQueue, sendMessage, requestRender, nodeRefFromName, canvas } = mutable();
  const absent = Object.entries({
    messageQueue: Array.isArray(messageQueue),
    sendMessage: typeof sendMessage === "function",
    requestRender: typeof requestRender === "function",
    nodeRefFromName: typeof nodeRefFromName === "object",
    canvas: canvas instanceof HTMLCanvasElement,
  })
    .filter(([, there]) => !there)
    .map(([name]) => name);
  if (absent.length === 0) return null;
  return `The boards need viser 1.1.1; this page's viser lacks ${absent.join(", ")}.`;
}

/**
 * Take our messages out of viser's queue before it handles them.
 * @param {(kind: string, body: unknown) => void} hear
 */
export function listen(hear) {
  const queue = mutable().messageQueue;
  const push = queue.push;
  queue.push = (...messages) => {
    for (const message of messages) {
      if (message.type !== MESSAGE_TYPES.down) {
        push.call(queue, message);
        continue;
      }
      const { kind, body } = /** @type {Shown} */ (message);
      hear(kind, body);
    }
    return queue.length;
  };
}

/** @param {import("./messages.js").Asked} asked */
export function send(asked) {
  mutable().sendMessage({ type: MESSAGE_TYPES.up, payload: JSON.stringify(asked) });
}

/**
 * viser calls a lost server again only from a page that has the focus. A page on a projector seldom
 * has it: being seen is enough.
 */
export function callAgainWhileSeen() {
  document.hasFocus = () => document.visibilityState === "visible";
  document.addEventListener("visibilitychange", () => dispatchEvent(new Event("focus")));
}

export const requestRender = () => mutable().requestRender();

/** @type {(name: string) => Node3 | undefined} */
export const sceneNode = (name) => mutable().nodeRefFromName[name];

/** The box that the canvas fills, which may be made smaller. @returns {HTMLElement | null} */
export function canvasFrame() {
  let found = mutable().canvas?.parentElement ?? null;
  for (let i = 0; found && i < WAY_UP; i++) {
    if (found.style.zIndex === "0") return found;
    found = found.parentElement;
  }
  return null;
}

/** On a phone: viser's own sheet, which else lies over what is ours. @returns {HTMLElement | null} */
export function phoneSheet() {
  for (const sheet of document.querySelectorAll(".mantine-Paper-root")) {
    const { position, zIndex } = /** @type {HTMLElement} */ (sheet).style;
    if (position === "fixed" && zIndex === "10") return /** @type {HTMLElement} */ (sheet);
  }
  return null;
}

/**
 * Fold viser's sheet away; a tap on its head opens it.
 * @param {HTMLElement} sheet
 * @returns {HTMLElement | null} its head
 */
export function foldSheet(sheet) {
  for (const part of sheet.querySelectorAll("div")) {
    if (part.style.cursor !== "pointer" || part.style.height !== "3.5em") continue;
    part.click();
    return part;
  }
  return null;
}

const TURN_KEYS = new Set("wasdqe");

/** Call back when a hand has turned or moved the camera. @param {() => void} turned */
export function onTurn(turned) {
  const { canvas } = mutable();
  let held = false;
  canvas?.addEventListener("pointerdown", () => {
    held = true;
  });
  canvas?.addEventListener("wheel", turned);
  addEventListener("pointerup", () => {
    if (held) turned();
    held = false;
  });
  addEventListener("keyup", ({ target, key }) => {
    if (target !== document.body && target !== canvas) return;
    if (TURN_KEYS.has(key.toLowerCase()) || key.startsWith("Arrow")) turned();
  });
}

/** The tabs of viser's main panel: of all its lists of tabs the longest. @returns {HTMLElement[]} */
export function panelTabs() {
  /** @type {HTMLElement[]} */
  let found = [];
  for (const list of document.querySelectorAll('[role="tablist"]')) {
    const tabs = /** @type {HTMLElement[]} */ ([...list.querySelectorAll('[role="tab"]')]);
    if (tabs.length > found.length) found = tabs;
  }
  return found.length > 1 ? found : [];
}

/** A docked tab answers to keys, one on a phone to a click. @param {HTMLElement} tab */
export function openTab(tab) {
  tab.dispatchEvent(new KeyboardEvent("keydown", { key: "Enter", bubbles: true }));
  tab.click();
}

/** Above an element of one of viser's panels: the box whose height it may fill. @type {(host: Element) => HTMLElement | null} */
export function panelOf(host) {
  let found = host.parentElement;
  while (found && found !== document.body) {
    const { overflowY } = getComputedStyle(found);
    if (/auto|scroll|hidden/.test(overflowY) && found.clientHeight > 0) return found;
    found = found.parentElement;
  }
  return null;
}
