/**
 * Where the parts stand: the boards in viser's docked panels, the time bar below the canvas. On a
 * phone one board and the time bar share the lower half of the screen.
 *
 * viser's page may throw a panel's content away and make it anew at any time: the boards are ours,
 * and are put back into whatever holds their place.
 */

import {
  canvasFrame,
  foldSheet,
  openTab,
  PHONE,
  panelOf,
  panelTabs,
  phoneSheet,
} from "./bridge.js";
import { element, say } from "./page.js";

/** @typedef {import("./board.js").Board} Board */

const PADDING = 8; // pixels between a board and its panel's lower edge
const LEAST_BOARD = 220; // pixels; a lower panel scrolls

export class Layout {
  /**
   * @param {Board[]} boards
   * @param {import("./timebar.js").TimeBar} timebar
   * @param {{ name: string, root: HTMLElement }[]} parts within viser's panels, of their own height
   * @param {object} calls
   * @param {(asked: import("./messages.js").Asked) => void} calls.ask
   * @param {() => void} calls.fitted the canvas may have another size
   * @param {() => void} calls.looked a person has opened another tab
   */
  constructor(boards, timebar, parts, { ask, fitted, looked }) {
    this.boards = boards;
    this.timebar = timebar;
    this.parts = parts;
    this.ask = ask;
    this.fitted = fitted;
    this.looked = looked;
    this.tab = ""; // the open one of viser's main panel; "": the first
    /** @type {string | null} */ this.wanted = null; // the one to open once it is there
    this.phone = matchMedia(PHONE);
    this.shown = 0; // which board a phone shows
    /** @type {WeakSet<Element>} */ this.watched = new WeakSet();
    /** @type {HTMLElement | null} */ this.head = null; // what stays of viser's panels on a phone
    /** @type {WeakSet<Element>} */ this.moved = new WeakSet();
    this.resized = new ResizeObserver(() => this.arrange());
    this.notice = element("div", { class: "rb-notice", role: "status", hidden: true });
    this.choices = boards.map((board, i) => this.choice(board, i));
    this.slot = element("div", { class: "rb-slot" });
    this.sheet = element("div", { class: "rb-phone", hidden: true }, [
      element("div", { class: "rb-row" }, [
        ...this.choices,
        element("span", { class: "rb-grow" }),
        this.button("Undo", "↶", { type: "Undo" }),
        this.button("Redo", "↷", { type: "Redo" }),
      ]),
      this.slot,
    ]);
    document.body.append(this.sheet, this.notice);
    new MutationObserver(() => this.arrange()).observe(document.body, {
      childList: true,
      subtree: true,
      attributeFilter: ["aria-selected"],
    });
    this.phone.addEventListener("change", () => this.arrange());
    addEventListener("resize", () => this.arrange());
    this.arrange();
  }

  /** @param {Board} board @param {number} i */
  choice(board, i) {
    const made = element("button", {
      class: "rb-chip",
      type: "button",
      "aria-pressed": String(i === 0),
    });
    const second = board.name.endsWith("-2") ? " 2" : "";
    made.textContent = `${board.name.startsWith("map") ? "Map" : "Landscape"}${second}`;
    made.hidden = second !== "";
    made.addEventListener("click", () => {
      this.shown = i;
      this.choices.forEach((one, k) => {
        one.setAttribute("aria-pressed", String(k === i));
      });
      this.arrange();
    });
    return made;
  }

  /** How many models' boards there are to choose from. @param {number} pairs */
  showPairs(pairs) {
    this.choices.forEach((choice, i) => {
      choice.hidden = i >= 2 * pairs;
    });
    if (this.choices[this.shown]?.hidden) this.choices[0]?.click();
  }

  /** @param {string} label @param {string} text @param {import("./messages.js").Asked} asked */
  button(label, text, asked) {
    const made = element("button", {
      class: "rb-button",
      type: "button",
      "aria-label": label,
      text,
    });
    made.addEventListener("click", () => this.ask(asked));
    return made;
  }

  arrange() {
    const phone = this.phone.matches;
    if (this.sheet.hidden === phone) this.sheet.hidden = !phone;
    for (const { name, root } of this.parts) {
      const host = document.getElementById(`rnnpb-${name}`);
      if (host && host.firstElementChild !== root) host.replaceChildren(root);
    }
    if (phone) this.arrangePhone();
    else this.arrangeDesk();
    this.fitCanvas(phone ? this.sheet : this.timebar.root, phone);
    this.arrangeTab();
  }

  /** @param {string} name of a tab of viser's main panel; "": the first */
  openTab(name) {
    this.wanted = name;
    this.arrangeTab();
  }

  arrangeTab() {
    const tabs = panelTabs();
    const named = tabs.map((tab, i) => (i ? (tab.textContent ?? "") : ""));
    const open = tabs.findIndex((tab) => tab.ariaSelected === "true");
    if (open < 0) return;
    const wanted = this.wanted === null ? -1 : named.indexOf(this.wanted);
    this.wanted = null;
    if (wanted >= 0 && wanted !== open) openTab(tabs[wanted]);
    else if (this.tab !== named[open]) {
      this.tab = named[open] ?? "";
      this.looked();
    }
  }

  arrangePhone() {
    const board = this.boards[this.shown];
    if (board && this.slot.firstElementChild !== board.root) this.slot.replaceChildren(board.root);
    if (this.timebar.root.parentElement !== this.sheet) this.sheet.append(this.timebar.root);
    this.timebar.root.style.cssText = "";
    this.moveSheet();
  }

  /** viser's own panels hang from the top on a phone, folded, like a menu. */
  moveSheet() {
    const sheet = phoneSheet();
    if (!sheet || this.moved.has(sheet)) return;
    this.moved.add(sheet);
    const { style } = sheet;
    [style.top, style.bottom, style.minHeight, style.maxHeight] = ["0", "auto", "0", "46%"];
    [style.left, style.width] = ["0", "auto"];
    this.head = foldSheet(sheet);
  }

  arrangeDesk() {
    if (this.timebar.root.parentElement !== document.body) document.body.append(this.timebar.root);
    for (const board of this.boards) {
      const host = document.getElementById(`rnnpb-${board.name}`);
      if (!host) continue;
      if (host.firstElementChild !== board.root) host.replaceChildren(board.root);
      const panel = panelOf(host);
      if (!panel) continue;
      this.watch(panel);
      const above =
        host.getBoundingClientRect().top - panel.getBoundingClientRect().top + panel.scrollTop;
      const height = Math.max(panel.clientHeight - above - PADDING, LEAST_BOARD);
      if (host.style.height !== `${height}px`) host.style.height = `${height}px`;
    }
  }

  /** @param {Element} box */
  watch(box) {
    if (this.watched.has(box)) return;
    this.watched.add(box);
    this.resized.observe(box);
  }

  /** The canvas ends where the part below it begins. @param {HTMLElement} part @param {boolean} phone */
  fitCanvas(part, phone) {
    const frame = canvasFrame();
    if (!frame) return;
    this.watch(frame);
    this.watch(part);
    const above = phone ? (this.head?.offsetHeight ?? 0) : 0;
    const room = `calc(100% - ${part.offsetHeight + above}px)`;
    if (frame.style.height !== room) frame.style.height = room;
    if (frame.style.marginTop !== `${above}px`) frame.style.marginTop = `${above}px`;
    const box = frame.getBoundingClientRect();
    this.fitted();
    if (phone) return;
    const { style } = part;
    for (const [name, value] of /** @type {const} */ ([
      ["left", box.left],
      ["width", box.width],
    ])) {
      if (style[name] !== `${value}px`) style[name] = `${value}px`;
    }
  }

  /** @param {string} text one line; none takes it away @param {"info" | "problem"} kind */
  say(text, kind) {
    this.notice.hidden = text === "";
    this.notice.dataset.kind = kind;
    say(this.notice, text);
  }
}
