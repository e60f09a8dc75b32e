// Runs beside each other: what differs between them, charts over each other, two in 3D with one camera.
import { get } from "./api.js";
import { draw } from "./chart.js";
import { el, number, put, state } from "./dom.js";
import { Player } from "./player.js";

/**
 * @param {HTMLElement} main
 * @param {string[]} ids
 * @returns {Promise<() => void>}
 */
export async function showCompare(main, ids) {
  document.title = "Compare · Mercury";
  const runs = await Promise.all(ids.slice(0, 20).map((id) => get(`/runs/${id}`)));
  const tables = await Promise.all(runs.map((run) => get(`/runs/${run.id}/tables`)));
  /** What is set in each run, by key. */
  const sets = runs.map((run) => Object.fromEntries(run.spec.set.map((/** @type {string} */ one) => one.split(/=(.*)/s).slice(0, 2))));
  const keys = [...new Set(sets.flatMap((set) => Object.keys(set)))].filter((key) => new Set(sets.map((set) => set[key])).size > 1);
  const label = runs.every((run) => run.label && run.label === runs[0].label) ? runs[0].label : "";
  /** @type {any} */
  const found = label ? await get(`/studies/${encodeURIComponent(label)}/table`).catch(() => null) : null;
  /** @param {string} id */
  const results = (id) => found?.rows.find((/** @type {any} */ row) => row.id === id)?.results ?? {};
  const names = [...new Set(runs.flatMap((run) => Object.keys(results(run.id))))];
  /** @param {number} k */
  const called = (k) => (keys.length ? keys.map((key) => `${key.split(".").pop()} ${sets[k][key] ?? "–"}`).join(", ") : `${runs[k].title} ${runs[k].id.slice(0, 4)}`);

  // Tables of runs with other names of scenes are the same table by what follows the first dot.
  /** @param {string} file */
  const kind = (file) => file.slice(file.indexOf(".") + 1);
  const choices = tables[0]?.flatMap((/** @type {any} */ table) => (table.names.length ? table.names : [null]).flatMap((/** @type {string | null} */ name) => table.columns.map((/** @type {string} */ column) => ({ kind: kind(table.file), column, name })))) ?? [];
  const chosen = el("select", { "aria-label": "Column", onchange: plot }, choices.map((/** @type {any} */ choice, /** @type {number} */ k) => el("option", { value: k }, `${choice.kind}: ${choice.name ? `${choice.name} ` : ""}${choice.column}`)));
  const start = choices.findIndex((/** @type {any} */ choice) => choice.column === "traKineticEnergy");
  if (start >= 0) chosen.value = String(start);
  const chart = el("div", { class: "chart" });
  let clear = () => {};
  async function plot() {
    const choice = choices[Number(chosen.value)];
    if (!choice) return;
    const curves = await Promise.all(runs.map(async (run, k) => {
      const table = tables[k].find((/** @type {any} */ table) => kind(table.file) === choice.kind);
      if (!table) return null;
      const query = new URLSearchParams({ file: table.file, column: choice.column });
      if (choice.name) query.set("name", choice.name);
      return { label: called(k), chart: await get(`/runs/${run.id}/charts?${query}`).catch(() => null) };
    }));
    clear();
    put(chart);
    clear = draw(chart, choice.column, /** @type {any} */ (curves.filter((curve) => curve?.chart)));
  }
  const pair = runs.length === 2 ? runs.map((run) => ({ run, box: el("div", { class: "grow" }) })) : [];
  put(main, el("h1", {}, label ? `Compare ${label}` : "Compare"),
    el("div", { class: "card scroll" }, el("table", {}, el("thead", {}, el("tr", {}, el("th", {}, "Run"), el("th", {}, "State"), keys.map((key) => el("th", { class: "number" }, key)), names.map((name) => el("th", { class: "number" }, name)))),
      el("tbody", {}, runs.map((run, k) => el("tr", {}, el("td", {}, el("a", { href: `/runs/${run.id}` }, run.title)), el("td", {}, state(run)),
        keys.map((key) => el("td", { class: "number" }, sets[k][key] ?? "")),
        names.map((name) => { const one = results(run.id)[name]; return el("td", { class: "number" }, one?.value != null ? `${number(one.value)} ${one.unit === "1" ? "" : one.unit ?? ""}` : ""); })))))),
    el("div", { class: "card" }, el("div", { class: "row" }, el("h2", {}, "Chart"), chosen), chart),
    pair.length > 0 && el("div", { class: "row" }, ...pair.map((one) => one.box)));
  await plot();
  const players = pair.map((one) => new Player(one.box, one.run, { title: called(runs.indexOf(one.run)) }));
  if (players.length === 2) players[0].viewer.share(players[1].viewer);
  await Promise.all(players.map((player) => player.load()));
  return () => { clear(); players.forEach((player) => player.end()); };
}
