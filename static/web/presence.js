/** Who presents this page, or follows another one: a bar above the robots. */

import { element, say } from "./page.js";

/** @typedef {import("./messages.js").PresenceShown} PresenceShown */
/** @typedef {import("./messages.js").Asked} Asked */

const KEY = "rnnpb.presenting"; // in the tab's own storage, as long as it presents
const FREE = "rnnpb.free"; // as long as it has let go of what it follows
const FOLLOW = "follow"; // in the page's address
const MARGIN = 8; // pixels

/** @type {(name: string) => string | null} */
function stored(name) {
  try {
    return sessionStorage.getItem(name);
  } catch {
    return null; // storage is switched off
  }
}

/** @type {(name: string, value: string | null) => void} */
function store(name, value) {
  try {
    if (value === null) sessionStorage.removeItem(name);
    else sessionStorage.setItem(name, value);
  } catch {
    // a reload then begins anew
  }
}

export class Presence {
  /** @param {(asked: Asked) => void} ask */
  constructor(ask) {
    this.ask = ask;
    this.text = element("span", { role: "status" });
    this.link = element("input", {
      class: "rb-link",
      type: "text",
      readonly: true,
      "aria-label": "Link for those who follow",
    });
    this.link.addEventListener("focus", () => this.link.select());
    this.action = element("button", { class: "rb-button", type: "button" });
    this.action.addEventListener("click", () => this.act());
    this.root = element("div", { class: "rb-presence", hidden: true }, [
      this.text,
      this.link,
      this.action,
    ]);
    document.body.append(this.root);
    /** @type {PresenceShown | null} */ this.shown = null;
  }

  /** What the first word of a connection says of it. */
  hello() {
    const follow = new URLSearchParams(location.search).get(FOLLOW);
    return {
      present: stored(KEY),
      follow: follow && /^[\w-]{12}$/.test(follow) ? follow : null,
      free: stored(FREE) !== null,
    };
  }

  /** @param {PresenceShown} shown */
  show(shown) {
    this.shown = shown;
    const { role, secret, code, followers, there, free } = shown;
    store(KEY, secret);
    store(FREE, role === "follows" && free ? "1" : null);
    this.root.hidden = role === "";
    this.link.hidden = role !== "presents";
    this.action.hidden = role === "follows" && !there && !free;
    const address = new URL(`?${FOLLOW}=${code}`, location.href);
    if (role === "presents") {
      this.link.value = address.href;
      say(this.text, followers === 1 ? "1 page follows" : `${followers} pages follow`);
      say(this.action, "Stop");
    } else if (free) {
      say(this.text, there ? "On your own" : "On your own; nobody presents");
      say(this.action, "Follow again");
    } else {
      say(this.text, there ? "Following" : "Waiting for who presents");
      say(this.action, "Let go");
    }
  }

  /** Stay above the robots, beside the boards. @param {DOMRect} box of the canvas */
  standOver(box) {
    const { style } = this.root;
    style.left = `${box.left + box.width / 2}px`;
    style.top = `${box.top + MARGIN}px`;
    style.maxWidth = `${box.width - 2 * MARGIN}px`;
  }

  act() {
    const { role, free } = this.shown ?? { role: "", free: false };
    if (role === "presents") this.ask({ type: "Present", on: false });
    else this.ask({ type: "Follow", on: free });
  }
}
