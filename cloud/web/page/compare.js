// Runs beside each other: what differs between them, charts over each other, two in 3D with one camera.
import { get } from "./api.js";
import { draw } from "./chart.js";
import { called, choices, column, logarithmic, titled } from "./charts.js";
import { differing, lines } from "./diff.js";
import { el, number, put, state } from "./dom.js";
import { Player } from "./player.js";
import { uncertain } from "./statistics.js";

/** Head of a column of results. @param {{name: string, unit: string}} column */
export const heading = (column) => (column.unit && column.unit !== "1" ? `${column.name} / ${column.unit}` : column.name);

/**
 * A card in which a column of a table of all runs is drawn, the runs over each other.
 * @param {{id: string, label: string, tables: any[]}[]} runs
 * @param {string} [wanted] the column, as `column` of an earlier card gives it
 * @returns {{chart: HTMLElement, column: () => string, end: () => void}}
 */
export function overlay(runs, wanted = "") {
  const all = choices(runs[0]?.tables ?? []);
  const log = { time: false, value: false };
  const chosen = el("select", { "aria-label": "Column", onchange: plot }, all.map((choice, k) => el("option", { value: k }, called(choice))));
  const start = all.findIndex((choice) => choice.column === "traKineticEnergy");
  const before = [...chosen.options].find((option) => option.text === wanted);
  if (before) chosen.value = before.value;
  else if (start >= 0) chosen.value = String(start);
  const place = el("div", { class: "chart" });
  let clear = () => {};
  let over = false;
  async function plot() {
    const choice = all[Number(chosen.value)];
    if (!choice) return put(place, el("p", { class: "quiet" }, "No table yet."));
    const curves = await Promise.all(runs.map(async (run) => {
      const own = choices(run.tables).find((own) => called(own) === called(choice));
      return own ? { label: run.label, chart: await column(run.id, own).catch(() => null) } : null;
    }));
    if (over) return;
    clear();
    put(place);
    clear = draw(place, titled(choice), /** @type {any} */ (curves.filter((curve) => curve?.chart)), log);
  }
  plot();
  return {
    chart: el("div", { class: "card" }, el("div", { class: "row" }, el("h2", {}, "Chart"), chosen, logarithmic(log, plot)), place),
    column: () => chosen.selectedOptions[0]?.text ?? "",
    end: () => { over = true; clear(); },
  };
}

/** What differs between the scenes of two runs. @param {any} first @param {any} other */
function scenes(first, other) {
  const found = differing(lines(first.scene, other.scene), 2);
  const title = el("h3", {}, `${first.title} ${first.id.slice(0, 4)} and ${other.title} ${other.id.slice(0, 4)}`);
  if (!found.length) return [title, el("p", { class: "quiet" }, "Their texts are the same.")];
  return [title, el("pre", { class: "diff", tabindex: "0" }, found.map(([mark, line]) => el("span", { class: mark === "+" ? "good" : mark === "-" ? "bad-text" : "quiet" }, `${mark} ${line}\n`)))];
}

/**
 * @param {HTMLElement} main
 * @param {string[]} ids
 * @returns {Promise<() => void>}
 */
export async function showCompare(main, ids) {
  document.title = "Compare · Mercury";
  const runs = await Promise.all(ids.slice(0, 20).map((id) => get(`/runs/${id}`)));
  const tables = await Promise.all(runs.map((run) => get(`/runs/${run.id}/tables`)));
  /** Settings of each run, by key. */
  const sets = runs.map((run) => Object.fromEntries(run.spec.set.map((/** @type {string} */ one) => one.split(/=(.*)/s).slice(0, 2))));
  const keys = [...new Set(sets.flatMap((set) => Object.keys(set)))].filter((key) => new Set(sets.map((set) => set[key])).size > 1);
  const study = runs.every((run) => run.study && run.study === runs[0].study) ? runs[0].study : null;
  const label = runs.every((run) => run.label && run.label === runs[0].label) ? runs[0].label : "";
  /** @type {any} */
  const found = study ? await get(`/studies/${study}`).catch(() => null) : null;
  /** @type {any[]} */
  const columns = found?.results ?? [];
  /** A result of a run, with its error. @param {string} id @param {number} c */
  const result = (id, c) => {
    const row = found?.rows.find((/** @type {any} */ row) => row.id === id);
    if (row?.results[c] == null) return "";
    return row.errors[c] ? uncertain(row.results[c], row.errors[c]) : number(row.results[c]);
  };
  /** @param {number} k */
  const labelOf = (k) => (keys.length ? keys.map((key) => `${key.split(".").pop()} ${sets[k][key] ?? "–"}`).join(", ") : `${runs[k].title} ${runs[k].id.slice(0, 4)}`);

  const { chart, end } = overlay(runs.map((run, k) => ({ id: run.id, label: labelOf(k), tables: tables[k] })));
  const pair = runs.length === 2 ? runs.map((run) => ({ run, box: el("div", { class: "grow" }) })) : [];
  put(main, el("h1", {}, label ? `Compare ${label}` : "Compare"),
    el("div", { class: "card scroll" }, el("table", {}, el("thead", {}, el("tr", {}, el("th", {}, "Run"), el("th", {}, "State"), keys.map((key) => el("th", { class: "number" }, key)), columns.map((column) => el("th", { class: "number" }, heading(column))))),
      el("tbody", {}, runs.map((run, k) => el("tr", {}, el("td", {}, el("a", { href: `/runs/${run.id}` }, run.title)), el("td", {}, state(run)),
        keys.map((key) => el("td", { class: "number" }, sets[k][key] ?? "")),
        columns.map((_, c) => el("td", { class: "number" }, result(run.id, c)))))))),
    chart,
    pair.length > 0 && el("div", { class: "row top" }, ...pair.map((one) => one.box)),
    el("div", { class: "card" }, el("h2", {}, "Scenes"), runs.slice(1).map((run) => scenes(runs[0], run))));
  const players = pair.map((one, k) => new Player(one.box, one.run, { title: labelOf(runs.indexOf(one.run)), led: k > 0 }));
  if (players.length === 2) {
    players[0].viewer.share(players[1].viewer);
    players[0].lead(players[1]);
  }
  await Promise.all(players.map((player) => player.load()));
  return () => { end(); players.forEach((player) => player.end()); };
}
