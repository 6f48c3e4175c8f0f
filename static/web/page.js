/** Small helpers for the page's own elements. */

/**
 * An element with attributes and children; `text` sets its text.
 * @template {keyof HTMLElementTagNameMap} Tag
 * @param {Tag} tag
 * @param {Record<string, string | number | boolean>} [attributes]
 * @param {(Node | null)[]} [children]
 * @returns {HTMLElementTagNameMap[Tag]}
 */
export function element(tag, attributes = {}, children = []) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name === "text") made.textContent = String(value);
    else if (value === true) made.setAttribute(name, "");
    else if (value !== false) made.setAttribute(name, String(value));
  }
  for (const child of children) if (child) made.append(child);
  return made;
}

/** Set a text only where it differs, so that a screen reader hears it once. @type {(node: Element, text: string) => void} */
export function say(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

/** viser's own setting where it has one, else the system's. */
export function isDark() {
  const set = document.documentElement.getAttribute("data-mantine-color-scheme");
  if (set === "dark" || set === "light") return set === "dark";
  return matchMedia("(prefers-color-scheme: dark)").matches;
}

/** Call back when the page turns dark or light. @type {(callback: () => void) => void} */
export function onSchemeChange(callback) {
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", callback);
  new MutationObserver(callback).observe(document.documentElement, {
    attributes: true,
    attributeFilter: ["data-mantine-color-scheme"],
  });
}

const FULL_HEIGHT = 1080; // CSS pixels of a window in which everything has its own size
const MOST_SCALE = 2;

/** How much larger all is drawn in a very large window, where CSS pixels are small. */
export const pageScale = () => Math.min(Math.max(innerHeight / FULL_HEIGHT, 1), MOST_SCALE);

/**
 * A canvas as large as its parent and as sharp as the screen, drawn once a frame at most.
 */
export class Surface {
  /**
   * @param {HTMLElement} parent
   * @param {(context: CanvasRenderingContext2D, width: number, height: number) => void} draw on a
   *   clear canvas, in units of `pageScale` CSS pixels
   */
  constructor(parent, draw) {
    this.canvas = element("canvas", { "aria-hidden": "true" });
    parent.append(this.canvas);
    this.parent = parent;
    this.paint = draw;
    this.asked = false;
    this.width = 0;
    this.height = 0;
    this.draws = 0;
    new ResizeObserver(() => this.draw()).observe(parent);
  }

  /** Draw at the next frame; a pointer's event comes before it, so that it is the same one. */
  request() {
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame(() => this.draw());
  }

  draw() {
    this.asked = false;
    const ratio = window.devicePixelRatio || 1;
    const { clientWidth, clientHeight } = this.parent;
    if (clientWidth < 2 || clientHeight < 2) return;
    this.width = clientWidth / pageScale();
    this.height = clientHeight / pageScale();
    const wide = Math.round(clientWidth * ratio);
    const high = Math.round(clientHeight * ratio);
    if (this.canvas.width !== wide) this.canvas.width = wide;
    if (this.canvas.height !== high) this.canvas.height = high;
    const context = this.canvas.getContext("2d");
    if (!context) return;
    context.setTransform(wide / this.width, 0, 0, high / this.height, 0, 0);
    context.clearRect(0, 0, this.width, this.height);
    this.paint(context, this.width, this.height);
    this.draws += 1;
  }
}
