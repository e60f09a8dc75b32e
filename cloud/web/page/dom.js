// Elements and texts. Nothing here or elsewhere makes HTML from text: what comes from users is text, always.

/**
 * An element with attributes and children. Attributes that begin with `on` are listeners.
 * @param {string} tag
 * @param {Record<string, any>} [attributes]
 * @param {...any} children texts, nodes and lists of them; what is null or false is left out
 * @returns {any}
 */
export function el(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (name in element && typeof value !== "string") /** @type {any} */ (element)[name] = value;
    else if (value !== false && value != null) element.setAttribute(name, value);
  }
  put(element, ...children);
  return element;
}

/**
 * Replaces the children of an element.
 * @param {Element} element
 * @param {...any} children
 */
export function put(element, ...children) {
  const nodes = children.flat(3).filter((child) => child !== null && child !== undefined && child !== false);
  element.replaceChildren(.../** @type {(string | Node)[]} */ (nodes.map((child) => (child instanceof Node ? child : String(child)))));
}

/**
 * Says something for some seconds.
 * @param {string} text
 * @param {boolean} [bad]
 */
export function toast(text, bad = false) {
  const note = el("div", { class: bad ? "toast bad" : "toast" }, text);
  document.getElementById("toasts")?.append(note);
  setTimeout(() => note.remove(), bad ? 9000 : 4000);
}

/**
 * Asks before something that cannot be taken back; resolves to what was typed, "" without a field, or null.
 * @param {string} title
 * @param {string} text
 * @param {string} yes
 * @param {{label: string, value: string, type?: string, lines?: number}} [field] with `lines` several lines, and `value` an example
 * @returns {Promise<string | null>}
 */
export function ask(title, text, yes, field) {
  return new Promise((resolve) => {
    const input = field && (field.lines ? el("textarea", { rows: String(field.lines), class: "grow", placeholder: field.value, spellcheck: "false" }) : el("input", { type: field.type ?? "text", value: field.value, step: "any", class: "grow" }));
    const form = el("form", { method: "dialog" },
      el("h2", {}, title), el("p", {}, text),
      field && el("p", {}, el("label", {}, field.label, input)),
      el("div", { class: "row" }, el("button", { class: "main", value: "yes" }, yes), el("button", { value: "no", formnovalidate: "" }, "Cancel")));
    const dialog = el("dialog", { onclose: () => {
      resolve(dialog.returnValue === "yes" ? (input ? input.value : "") : null);
      dialog.remove();
    } }, form);
    document.body.append(dialog);
    dialog.showModal();
  });
}

/** @param {number | null | undefined} bytes */
export function size(bytes) {
  if (bytes == null) return "";
  const units = ["B", "kB", "MB", "GB", "TB"];
  let at = 0;
  while (bytes >= 999.5 && at < units.length - 1) { bytes /= 1000; at += 1; }
  return `${at && bytes < 10 ? bytes.toFixed(1) : Math.round(bytes)} ${units[at]}`;
}

/** @param {number | null | undefined} seconds */
export function duration(seconds) {
  if (seconds == null || !Number.isFinite(seconds)) return "";
  if (seconds < 1) return "less than 1 s";
  if (seconds < 90) return `${Math.round(seconds)} s`;
  if (seconds < 5400) return `${Math.round(seconds / 60)} min`;
  if (seconds < 172800) return `${(seconds / 3600).toFixed(1)} h`;
  return `${(seconds / 86400).toFixed(1)} days`;
}

/** @param {number | null | undefined} value */
export function number(value) {
  if (value == null || !Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  if (value !== 0 && (size >= 1e6 || size < 1e-3)) return value.toExponential(3).replace("e+", "e");
  return String(Number(value.toPrecision(5)));
}

/** @param {number} count */
export const whole = (count) => count.toLocaleString("en");

/** @param {number} unix */
export function ago(unix) {
  const seconds = Date.now() / 1000 - unix;
  if (seconds < 10) return "just now";
  return seconds < 604800 ? `${duration(seconds)} ago` : new Date(unix * 1000).toLocaleDateString();
}

/** @param {{state: string}} run */
export const state = (run) => el("span", { class: `state ${run.state}` }, run.state);
