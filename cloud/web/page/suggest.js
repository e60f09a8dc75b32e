// Completion and help in the editor of a scene: a list at the caret, and the meaning of the key there in a line below.
import { get } from "./api.js";
import { complete } from "./complete.js";
import { el, put } from "./dom.js";

/** The most entries of the list. */
const MOST = 60;

/** Schema of scenes, fetched once. @type {Promise<any> | null} */
let schema = null;

/**
 * Adds completion to a text area within a box that is its editor.
 * @param {HTMLElement} box
 * @param {HTMLTextAreaElement} area
 * @param {HTMLElement} help line for the meaning of the key at the caret
 * @param {() => boolean} isToml
 */
export function suggest(box, area, help, isToml) {
  const list = el("ul", { class: "suggestions", role: "listbox", id: "suggestions", "aria-label": "What can stand here", hidden: true });
  box.append(list);
  area.setAttribute("aria-autocomplete", "list");
  area.setAttribute("aria-controls", "suggestions");
  /** @type {{text: string, help: string}[]} */
  let shown = [];
  let [from, chosen] = [0, -1];
  schema ??= get("/schema").catch(() => { schema = null; return null; });

  function close() {
    list.hidden = true;
    shown = [];
    area.removeAttribute("aria-activedescendant");
  }

  /** Places the list under the caret, or above it in the lower half. */
  function place() {
    const before = area.value.slice(0, area.selectionStart).split("\n");
    const style = getComputedStyle(area);
    const [line, pad] = [parseFloat(style.lineHeight), parseFloat(style.paddingTop)];
    const ink = document.createElement("canvas").getContext("2d");
    if (!ink) return;
    ink.font = style.font;
    const column = ink.measureText((before.at(-1) ?? "").replaceAll("\t", "  ")).width;
    const top = pad + before.length * line - area.scrollTop;
    const left = area.offsetLeft + pad + column - area.scrollLeft;
    const above = top > area.clientHeight / 2;
    Object.assign(list.style, { left: `${Math.max(0, Math.min(left, box.clientWidth - 300))}px`, top: above ? "auto" : `${top}px`, bottom: above ? `${box.clientHeight - top + line}px` : "auto" });
  }

  /** @param {number} k */
  function choose(k) {
    chosen = (k + shown.length) % shown.length;
    [...list.children].forEach((entry, n) => entry.setAttribute("aria-selected", String(n === chosen)));
    list.children[chosen].scrollIntoView({ block: "nearest" });
    area.setAttribute("aria-activedescendant", `suggestion-${chosen}`);
  }

  /** Puts an entry in the place of what was typed. @param {{text: string}} one */
  function take(one) {
    area.setSelectionRange(from, area.selectionStart);
    // As typed: it can be undone.
    if (!document.execCommand("insertText", false, one.text)) {
      area.setRangeText(one.text, from, area.selectionEnd, "end");
      area.dispatchEvent(new Event("input"));
    }
    close();
  }

  /** Shows help for the key at the caret, and what can stand there where that was typed or wished for. @param {boolean} offer */
  async function look(offer) {
    const root = await schema;
    if (!root || !isToml() || area.selectionStart !== area.selectionEnd) { put(help); return close(); }
    const found = complete(root, area.value, area.selectionStart);
    put(help, found.help || "Ctrl+Space shows what can stand here.");
    if (!offer || !found.candidates.length) return close();
    ({ from } = found);
    chosen = -1;
    shown = found.candidates.slice(0, MOST);
    put(list, shown.map((one, k) => el("li", { role: "option", id: `suggestion-${k}`, "aria-selected": "false", onmousedown: (/** @type {Event} */ event) => { event.preventDefault(); take(one); } },
      el("b", {}, one.text), one.help && el("span", { class: "small quiet" }, ` ${one.help}`))));
    list.hidden = false;
    place();
  }

  area.addEventListener("input", (/** @type {any} */ event) => look(event.inputType === "insertText" && /[A-Za-z_."]/.test(event.data ?? "")));
  area.addEventListener("keydown", (/** @type {KeyboardEvent} */ event) => {
    if (event.key === " " && event.ctrlKey) { event.preventDefault(); look(true); return; }
    if (list.hidden) return;
    if (event.key === "ArrowDown") choose(chosen + 1);
    else if (event.key === "ArrowUp") choose(chosen < 0 ? -1 : chosen - 1);
    else if (event.key === "Escape") close();
    // Enter takes what was chosen by the arrows; else it begins a line, as ever.
    else if (event.key === "Tab" && !event.shiftKey) take(shown[Math.max(0, chosen)]);
    else if (event.key === "Enter" && chosen >= 0) take(shown[chosen]);
    else return;
    event.preventDefault();
  });
  area.addEventListener("keyup", (/** @type {KeyboardEvent} */ event) => { if (/^(Arrow(Left|Right|Up|Down)|Home|End|Page)/.test(event.key) && list.hidden) look(false); });
  area.addEventListener("click", () => look(false));
  area.addEventListener("blur", close);
  area.addEventListener("scroll", close);
}
