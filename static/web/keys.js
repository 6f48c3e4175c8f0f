/**
 * Space plays and pauses, wherever the focus is but in a field that one types in. A button that one
 * went to by key keeps its own Space; one that was merely clicked does not.
 */

const TYPING =
  "input:not([type=button], [type=checkbox], [type=radio], [type=range]), textarea, select, [contenteditable=true]";
const OWN_SPACE =
  "button, input, summary, [role=button], [role=tab], [role=checkbox], [role=switch]";

/**
 * @param {() => void} toggle
 * @param {HTMLElement} play the button that does the same, which is pressed once, not twice
 */
export function spaceToggles(toggle, play) {
  let byKey = false; // how the focus came to where it is
  addEventListener(
    "pointerdown",
    () => {
      byKey = false;
    },
    true,
  );
  addEventListener(
    "keydown",
    (event) => {
      if (event.key === "Tab") byKey = true;
    },
    true,
  );

  const mine = (/** @type {KeyboardEvent} */ event) => {
    if (event.key !== " " || event.ctrlKey || event.metaKey || event.altKey) return false;
    const at = document.activeElement;
    if (!at || at === play) return true;
    return !at.matches(TYPING) && !(byKey && at.matches(OWN_SPACE));
  };
  addEventListener(
    "keydown",
    (event) => {
      if (!mine(event)) return;
      event.preventDefault();
      event.stopPropagation();
      if (!event.repeat) toggle();
    },
    true,
  );
  // A button is pressed when Space is released.
  addEventListener(
    "keyup",
    (event) => {
      if (!mine(event)) return;
      event.preventDefault();
      event.stopPropagation();
    },
    true,
  );
}
