// Files of a run, shown within the page before they are fetched: pictures, and the begin of texts and tables.
import { el, put, size, whole } from "./dom.js";

/** How much of a text is shown, in bytes. */
const MOST = 65536;

/** The most rows of a table that are shown. */
const ROWS = 200;

/** Whether a file can be shown. @param {{name: string, bytes: number}} file */
export const isShown = (file) => file.bytes > 0 && /\.(png|toml|csv|ene|fields|log|json|txt|data|svg)$/.test(file.name);

/** Cells of a line: at commas outside of quotes where it has some, else at blanks. @param {string} line */
export const cells = (line) => (line.includes(",") ? [...`,${line}`.matchAll(/,(?:"((?:[^"]|"")*)"|([^,]*))/g)].map(([, quoted, plain]) => quoted?.replaceAll('""', '"') ?? plain) : line.trim().split(/\s+/));

/**
 * Shows a file in a dialog.
 * @param {{name: string, bytes: number}} file
 * @param {string} address
 */
export async function showFile(file, address) {
  const body = el("div", { class: "scroll", tabindex: "0" }, "…");
  const dialog = el("dialog", { class: "wide", onclose: () => dialog.remove(), "aria-label": file.name },
    el("div", { class: "row spread" }, el("h2", {}, file.name), el("form", { method: "dialog" }, el("a", { class: "button", href: address, download: file.name.split("/").pop() }, `Download, ${size(file.bytes)}`), " ", el("button", {}, "Close"))), body);
  document.body.append(dialog);
  dialog.showModal();
  if (file.name.endsWith(".png")) return put(body, el("img", { src: address, alt: file.name, class: "still" }));
  const answer = await fetch(address, { headers: { range: `bytes=0-${MOST - 1}` } }).catch(() => null);
  if (!answer?.ok) return put(body, el("p", { class: "bad-text" }, "The file cannot be read now."));
  const lines = (await answer.text()).split("\n");
  const rest = file.bytes > MOST;
  // The last line may be cut.
  if (rest) lines.pop();
  const table = /\.(csv|ene|fields)$/.test(file.name) ? lines.filter((line) => line && !line.startsWith("#")) : [];
  const note = rest || table.length > ROWS ? el("p", { class: "small quiet" }, table.length ? `The first ${whole(Math.min(ROWS, table.length - 1))} rows.` : `The first ${size(MOST)}.`) : null;
  if (!table.length) return put(body, note, el("pre", {}, lines.join("\n")));
  put(body, note, el("table", {}, el("thead", {}, el("tr", {}, cells(table[0]).map((cell) => el("th", { class: "number" }, cell)))),
    el("tbody", {}, table.slice(1, ROWS + 1).map((line) => el("tr", {}, cells(line).map((cell) => el("td", { class: "number" }, cell)))))));
}
