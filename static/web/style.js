/** How the browser's part looks; colours of what the canvases draw are in colors.js. */

import { pageScale } from "./page.js";

const SHEET = `
:root {
  --rb-text: #2b3440; --rb-quiet: #66707c; --rb-surface: var(--mantine-color-body, #fff); --rb-raised: #f4f6f8;
  --rb-line: #dde2e7; --rb-accent: #0072b2; --rb-warning: #a84300; --rb-warning-fill: #fff1e0;
}
:root[data-rb-dark] {
  --rb-text: #dfe4ea; --rb-quiet: #9aa4af; --rb-surface: var(--mantine-color-body, #1f2226); --rb-raised: #2a2e34;
  --rb-line: #3a4048; --rb-accent: #56b4e9; --rb-warning: #ffb47a; --rb-warning-fill: #4a2f14;
}
.rb-board, .rb-timebar, .rb-phone, .rb-notice {
  font: 500 12px/1.3 Inter, "Inter Variable", system-ui, sans-serif;
  color: var(--rb-text); box-sizing: border-box; font-variant-numeric: tabular-nums;
}
.rb-board *, .rb-timebar *, .rb-phone * { box-sizing: border-box; }
.rb-unseen {
  position: absolute; width: 1px; height: 1px; overflow: hidden; clip-path: inset(50%);
  white-space: nowrap;
}
#rnnpb-map, #rnnpb-landscape { width: 100%; min-height: 220px; }
.rb-board {
  position: relative; display: flex; flex-direction: column; height: 100%; width: 100%;
  container-type: size; padding: 2px 6px 0; gap: 2px;
}
.rb-head, .rb-legend, .rb-tip, .rb-mark, .rb-timebar .rb-row { zoom: var(--rb-scale, 1); }
.rb-head { display: flex; align-items: center; gap: 8px; min-height: 24px; }
.rb-title { font-weight: 650; overflow: hidden; text-overflow: ellipsis; white-space: nowrap; }
.rb-readout { color: var(--rb-quiet); white-space: nowrap; }
.rb-tools { margin-left: auto; display: flex; gap: 4px; flex: none; }
.rb-chip, .rb-button, .rb-select {
  font: inherit; color: inherit; background: var(--rb-raised); border: 1px solid var(--rb-line);
  border-radius: 6px; height: 22px; padding: 0 7px; cursor: pointer; white-space: nowrap;
}
.rb-button { min-width: 30px; }
.rb-chip[aria-pressed=true], .rb-button[aria-pressed=true] {
  background: var(--rb-accent); border-color: var(--rb-accent); color: var(--rb-surface);
}
.rb-chip:focus-visible, .rb-button:focus-visible, .rb-select:focus-visible,
.rb-plot:focus-visible, .rb-curves:focus-visible, .rb-steps:focus-visible {
  outline: 2px solid var(--rb-accent); outline-offset: 1px;
}
.rb-plot.rb-by-hand:focus-visible { outline: none; }
.rb-chip[hidden], .rb-mark[hidden], .rb-tip[hidden], .rb-notice[hidden], .rb-phone[hidden] {
  display: none;
}
.rb-body { flex: 1; min-height: 0; display: flex; flex-direction: column; gap: 4px; }
.rb-plot {
  position: relative; flex: 1; min-height: 0; min-width: 0; touch-action: none; user-select: none;
  -webkit-user-select: none; border-radius: 4px;
}
.rb-whose {
  position: absolute; right: 16px; top: 7px; z-index: 1; pointer-events: none; font-weight: 650;
  padding: 0 4px; border-radius: 4px; background: color-mix(in srgb, var(--rb-surface) 75%, transparent);
}
.rb-whose:empty { display: none; }
.rb-presence {
  position: fixed; transform: translateX(-50%); z-index: 4; display: flex;
  align-items: center; gap: 8px; padding: 4px 4px 4px 12px; border-radius: 8px;
  font: 600 12px/1.3 Inter, "Inter Variable", system-ui, sans-serif; color: var(--rb-text);
  background: var(--rb-surface); border: 1px solid var(--rb-line); box-shadow: 0 1px 6px rgb(0 0 0 / 0.15);
}
.rb-presence[hidden], .rb-presence [hidden] { display: none; }
.rb-link {
  font: inherit; font-weight: 500; color: inherit; width: 190px; min-width: 0; height: 26px; padding: 0 6px;
  background: var(--rb-raised); border: 1px solid var(--rb-line); border-radius: 6px;
}
.rb-steps { position: relative; width: 100%; height: 100%; cursor: pointer; touch-action: none; }
.rb-plot canvas, .rb-curves canvas, .rb-steps canvas {
  position: absolute; inset: 0; width: 100%; height: 100%; display: block; pointer-events: none;
}
.rb-mark {
  position: absolute; top: 12px; right: 14px; padding: 2px 8px; border-radius: 10px;
  background: var(--rb-warning-fill); color: var(--rb-warning); font-weight: 600; z-index: 1;
  pointer-events: none;
}
.rb-tip {
  position: absolute; z-index: 2; padding: 3px 8px; border-radius: 5px; pointer-events: none;
  background: var(--rb-text); color: var(--rb-surface); white-space: nowrap;
  box-shadow: 0 1px 5px rgb(0 0 0 / 0.3);
}
.rb-legend { flex: none; color: var(--rb-quiet); font-size: 11px; overflow: auto; scrollbar-width: thin; }
.rb-map .rb-legend { max-height: 46px; }
.rb-entries { display: flex; flex-wrap: wrap; gap: 1px 9px; }
.rb-entry { display: inline-flex; align-items: center; gap: 4px; white-space: nowrap; cursor: default; }
.rb-entry:hover { color: var(--rb-text); }
.rb-swatch { width: 9px; height: 9px; flex: none; }
.rb-scales { display: flex; flex-wrap: wrap; align-items: center; gap: 6px; padding: 2px 0 4px; }
.rb-scale { flex: 1; min-width: 40px; height: 9px; border-radius: 3px; max-width: 320px; }
.rb-landscape .rb-body { flex-direction: row; }
.rb-landscape .rb-legend {
  width: 84px; display: flex; flex-direction: column; gap: 6px; padding: 6px 0 4px;
}
.rb-key {
  display: grid; grid-template: repeat(3, auto) / 12px auto; gap: 0 6px; height: 40%; min-height: 60px;
}
.rb-key i { grid-row: 1 / 4; border-radius: 3px; border: 1px solid var(--rb-line); }
.rb-key span:nth-of-type(2) { align-self: center; }
.rb-key span:nth-of-type(3) { align-self: end; }
.rb-numbers { display: grid; grid-template-columns: auto 1fr; gap: 1px 6px; margin: 0; }
.rb-numbers dd { margin: 0; color: var(--rb-text); }
.rb-numbers .rb-stage, .rb-numbers .rb-note { grid-column: 1 / 3; }
.rb-numbers .rb-note { color: var(--rb-quiet); }
.rb-stage[data-complete=false] { color: var(--rb-warning); }
@container (min-aspect-ratio: 21/20) {
  .rb-scales { flex-wrap: wrap; justify-content: space-between; gap: 3px 6px; }
  .rb-scales b, .rb-scale { flex: 1 0 100%; }
  .rb-scale { order: -1; height: 12px; }
  .rb-scales b { order: -2; }
}
@container (max-aspect-ratio: 3/4) {
  .rb-map .rb-plot { flex: 0 1 auto; aspect-ratio: 9/10; }
  .rb-map .rb-legend { max-height: none; flex: 0 1 auto; }
}
@container (min-height: 400px) { .rb-map .rb-legend { max-height: 106px; } }
@container (max-width: 310px) { /* two models side by side: their names before all */
  .rb-title { flex: none; }
  .rb-readout { display: none; }
  .rb-tools { min-width: 0; }
  .rb-tools .rb-chip { max-width: 100%; overflow: hidden; text-overflow: ellipsis; white-space: nowrap; }
}
@container (max-aspect-ratio: 10/11) or (max-width: 310px) {
  .rb-landscape .rb-body { flex-direction: column; }
  .rb-landscape .rb-plot { flex: 0 1 auto; aspect-ratio: 1; }
  .rb-landscape .rb-legend { width: auto; flex-direction: row; gap: 18px; padding: 0 4px 6px 34px; overflow: hidden; }
  .rb-landscape .rb-key { height: auto; }
  .rb-landscape .rb-numbers { display: flex; flex-wrap: wrap; align-content: center; gap: 2px 6px; }
  .rb-landscape .rb-numbers dd { margin-right: 8px; }
  .rb-landscape .rb-note { width: 100%; }
}
@container (min-aspect-ratio: 21/20) {
  .rb-map .rb-body { flex-direction: row; }
  .rb-map .rb-legend { max-height: none; width: 104px; padding-top: 6px; }
  .rb-map .rb-entries { flex-direction: column; flex-wrap: nowrap; }
}
.rb-timebar .rb-select { min-width: 0; flex: 0 1 auto; }
.rb-timebar {
  position: fixed; bottom: 0; z-index: 3; height: clamp(124px, 18vh, 280px); padding: 6px 8px 2px;
  display: flex; flex-direction: column; gap: 4px; background: var(--rb-surface);
  border-top: 1px solid var(--rb-line); container-type: inline-size;
}
.rb-row { display: flex; align-items: center; gap: 6px; flex: none; min-width: 0; }
@container (max-width: 460px) { .rb-timebar .rb-value { display: none; } }
.rb-grow { flex: 1; }
.rb-row .rb-button, .rb-row .rb-select, .rb-row .rb-chip { height: 28px; }
.rb-play { width: 42px; background: var(--rb-accent); border-color: var(--rb-accent); color: var(--rb-surface); }
.rb-time { white-space: nowrap; }
.rb-value { color: var(--rb-quiet); overflow: hidden; text-overflow: ellipsis; white-space: nowrap; }
.rb-select { max-width: 130px; }
.rb-curves { position: relative; flex: 1; min-height: 0; touch-action: none; cursor: ew-resize; border-radius: 4px; }
.rb-phone {
  position: fixed; left: 0; right: 0; bottom: 0; height: 54%; z-index: 4; display: flex;
  flex-direction: column; gap: 4px; padding: 6px 6px 0; background: var(--rb-surface);
  border-top: 1px solid var(--rb-line); touch-action: none;
}
.rb-phone .rb-slot { flex: 1; min-height: 0; }
.rb-phone .rb-timebar { position: static; height: 92px; border: 0; padding: 0 0 2px; width: 100%; }
.rb-phone .rb-row .rb-button, .rb-phone .rb-row .rb-chip, .rb-phone .rb-row .rb-select { height: 36px; min-width: 40px; }
.rb-phone .rb-map .rb-legend, .rb-phone .rb-value { display: none; }
.rb-notice {
  position: fixed; top: 10px; left: 50%; transform: translateX(-50%); z-index: 20; max-width: 80vw;
  padding: 6px 14px; border-radius: 8px; background: var(--rb-raised); border: 1px solid var(--rb-line);
  box-shadow: 0 2px 10px rgb(0 0 0 / 0.2);
}
.rb-notice[data-kind=problem] { background: var(--rb-warning-fill); color: var(--rb-warning); border-color: var(--rb-warning); }
`;

/** @param {() => boolean} dark @param {(callback: () => void) => void} onChange */
export function installStyle(dark, onChange) {
  const style = document.createElement("style");
  style.textContent = SHEET;
  document.head.append(style);
  const set = () => document.documentElement.toggleAttribute("data-rb-dark", dark());
  set();
  onChange(set);
  const scale = () => document.documentElement.style.setProperty("--rb-scale", String(pageScale()));
  scale();
  addEventListener("resize", scale);
}
