// Charts that the user chooses: several at once, each of a column of a table of a run, with logarithmic axes where wanted.
import { get } from "./api.js";
import { box, draw } from "./chart.js";
import { el, put, toast } from "./dom.js";

/** The most charts at once. */
const MOST = 12;

/** Name under which this browser keeps the charts that were chosen. */
const KEPT = "charts";

/** @typedef {{file: string, kind: string, column: string, name: string | null, unit: string}} Choice */

/**
 * Columns of tables that charts can be made of. Runs with other names of scenes have the same tables by what follows the first dot.
 * @param {{file: string, columns: string[], units: string[], names: string[]}[]} tables
 * @returns {Choice[]}
 */
export const choices = (tables) => tables.flatMap((table) => (table.names.length ? table.names : [null]).flatMap((name) => table.columns.map((column, k) => ({ file: table.file, kind: table.file.slice(table.file.indexOf(".") + 1), column, name, unit: table.units[k] ?? "" }))));

/** @param {Choice} choice */
export const called = (choice) => `${choice.kind}: ${choice.name ? `${choice.name} ` : ""}${choice.column}`;

/** Title of a chart, with the unit. @param {Choice} choice */
export const titled = (choice) => `${choice.name ? `${choice.name} ` : ""}${choice.column}${choice.unit && choice.unit !== "1" ? ` / ${choice.unit}` : ""}`;

/** A column of a run, reduced for a chart. @param {string} run @param {Choice} choice */
export async function column(run, { file, column, name }) {
  const query = new URLSearchParams({ file, column });
  if (name) query.set("name", name);
  return get(`/runs/${run}/charts?${query}`);
}

/** Boxes for logarithmic axes. @param {{time: boolean, value: boolean}} log @param {() => void} changed */
export function logarithmic(log, changed) {
  const one = (/** @type {"time" | "value"} */ axis, /** @type {string} */ text) => {
    const box = el("input", { type: "checkbox", checked: log[axis], onchange: () => { log[axis] = box.checked; changed(); } });
    return el("label", { class: "small" }, box, text);
  };
  return [one("value", "log values"), one("time", "log time")];
}

export class Charts {
  /** @param {HTMLElement} place @param {string} run */
  constructor(place, run) {
    this.run = run;
    /** @type {Choice[]} */
    this.all = [];
    /** @type {{wanted: string, log: {time: boolean, value: boolean}, chosen: any, box: HTMLElement, card: HTMLElement, clear: () => void}[]} */
    this.cards = [];
    this.grid = el("div", { class: "charts" });
    this.more = el("button", { onclick: () => this.add() }, "Add a chart");
    put(place, this.grid, el("p", {}, this.more, el("span", { class: "small quiet" }, " Drag over a chart to magnify a part, double-click for all of it.")));
  }

  /** Charts that were chosen before, in this browser. @returns {{wanted: string, log: {time: boolean, value: boolean}}[]} */
  kept() {
    try { return JSON.parse(localStorage.getItem(KEPT) ?? "[]"); } catch { return []; }
  }

  keep() {
    // A browser that keeps nothing still draws.
    try { localStorage.setItem(KEPT, JSON.stringify(this.cards.map(({ wanted, log }) => ({ wanted, log })))); } catch { /* full, or forbidden */ }
  }

  /** Draws all charts anew from these tables. @param {any[]} tables */
  async show(tables) {
    const before = this.all.length;
    this.all = choices(tables);
    if (!this.all.length) return put(this.grid, el("p", { class: "quiet" }, "No table yet."));
    if (!before) {
      const there = this.kept().filter((one) => this.all.some((choice) => called(choice) === one.wanted));
      put(this.grid);
      for (const one of there.length ? there : [null]) this.add(one);
      return;
    }
    if (before !== this.all.length) this.cards.forEach((card) => this.fill(card));
    await Promise.all(this.cards.map((card) => this.plot(card)));
  }

  /** Adds a chart: that of before, or of the column behind the last one. @param {{wanted: string, log: {time: boolean, value: boolean}} | null} [one] */
  add(one = null) {
    if (this.cards.length >= MOST) return toast(`There are ${MOST} charts: remove one first.`);
    const last = this.all.findIndex((choice) => called(choice) === this.cards.at(-1)?.wanted);
    // The first one shows the kinetic energy, where there is one.
    const kinetic = this.cards.length ? -1 : this.all.findIndex((choice) => choice.column === "traKineticEnergy");
    const card = { wanted: one?.wanted ?? called(this.all[kinetic >= 0 ? kinetic : (last + 1) % this.all.length]), log: { time: false, value: false, ...one?.log }, chosen: el("select", { "aria-label": "Column" }), box: box(), card: el("div"), clear: () => {} };
    card.chosen.onchange = () => { card.wanted = called(this.all[Number(card.chosen.value)]); this.keep(); this.plot(card); };
    card.card = el("div", { class: "card" }, el("div", { class: "row" }, card.chosen, logarithmic(card.log, () => { this.keep(); this.plot(card); }),
      el("button", { class: "plain", "aria-label": "Remove this chart", onclick: () => this.remove(card) }, "×")), card.box);
    this.cards.push(card);
    this.grid.append(card.card);
    this.fill(card);
    if (!one) this.keep();
    return this.plot(card);
  }

  /** @param {any} card */
  remove(card) {
    card.clear();
    card.card.remove();
    this.cards.splice(this.cards.indexOf(card), 1);
    this.keep();
  }

  /** @param {any} card */
  fill(card) {
    put(card.chosen, ...this.all.map((choice, k) => el("option", { value: k, selected: called(choice) === card.wanted }, called(choice))));
  }

  /** @param {any} card */
  async plot(card) {
    const choice = this.all.find((choice) => called(choice) === card.wanted);
    if (!choice) return;
    const chart = await column(this.run, choice);
    // Another column may have been chosen meanwhile, or the page left.
    if (called(choice) !== card.wanted || !card.box.isConnected) return;
    card.clear();
    put(card.box);
    card.clear = draw(card.box, titled(choice), [{ label: choice.column, chart }], card.log);
  }

  end() {
    this.cards.forEach((card) => card.clear());
  }
}
