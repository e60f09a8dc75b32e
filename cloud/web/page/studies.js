// Studies: their list; of one its table, its plot, and charts of its runs over each other.
import { get, listen, post } from "./api.js";
import { scatter } from "./chart.js";
import { heading, overlay } from "./compare.js";
import { ago, el, number, put, state, toast } from "./dom.js";
import { numeric, points, uncertain } from "./statistics.js";
import { go } from "./app.js";

/** The most runs whose charts are drawn over each other. */
const MOST_CURVES = 20;

/** @param {Record<string, number>} states */
const counts = (states) => Object.entries(states).map(([word, count]) => el("span", { class: "small quiet" }, `${count} ${word} `));

/**
 * @param {HTMLElement} main
 * @param {URLSearchParams} wanted
 * @returns {Promise<() => void>}
 */
export async function showStudies(main, wanted) {
  document.title = "Studies · Mercury";
  const after = wanted.get("after");
  const page = await get(`/studies${after ? `?after=${after}` : ""}`);
  const rows = page.studies.map((/** @type {any} */ study) => el("tr", {},
    el("td", {}, el("a", { href: `/studies/${study.id}` }, study.title), el("div", { class: "small quiet code" }, study.id.slice(0, 8))),
    el("td", {}, counts(study.states)), el("td", { class: "number small" }, ago(study.created))));
  put(main, el("div", { class: "row spread" }, el("h1", {}, "Studies"), el("a", { class: "button main", href: "/new" }, "New run or study")),
    el("div", { class: "card scroll" }, rows.length ? el("table", {}, el("thead", {}, el("tr", {}, el("th", {}, "Study"), el("th", {}, "Runs"), el("th", { class: "number" }, "Submitted"))), el("tbody", {}, rows))
      : el("p", { class: "empty" }, "No study yet. A new run with values of a key is one.")),
    page.after && el("a", { class: "button", href: `/studies?after=${page.after}` }, "Older studies"));
  return () => {};
}

/**
 * @param {HTMLElement} main
 * @param {string} id
 * @returns {Promise<() => void>}
 */
export async function showStudy(main, id) {
  let table = await get(`/studies/${id}`);
  document.title = `${table.title} · Mercury`;
  /** @type {Set<string>} */
  const chosen = new Set();
  /** Column by which the table is sorted, and 1 or -1. */
  let [sorted, way] = [-1, 1];
  const head = el("tr");
  const body = el("tbody");
  const states = el("div", { class: "row" });
  const actions = el("div", { class: "row" });
  const place = el("div", { class: "chart" });
  const curves = el("div");
  const means = el("div");
  let clear = () => {};
  let end = () => {};
  const numbers = table.keys.map((/** @type {string} */ _, /** @type {number} */ k) => k).filter((/** @type {number} */ k) => table.rows.some((/** @type {any} */ row) => numeric(row.values[k]) !== null));
  const first = numbers.find((/** @type {number} */ k) => table.keys[k] !== "seed") ?? numbers[0];
  const across = el("select", { "aria-label": "Key across", onchange: () => plot() }, numbers.map((/** @type {number} */ k) => el("option", { value: k }, table.keys[k])));
  if (first !== undefined) across.value = String(first);
  const up = el("select", { "aria-label": "Result up", onchange: () => plot() }, table.results.map((/** @type {any} */ column, /** @type {number} */ k) => el("option", { value: k }, column.name)));
  const wished = table.results.findIndex((/** @type {any} */ column) => column.name === table.plots[0]);
  if (wished >= 0) up.value = String(wished);

  put(main, el("div", { class: "row spread" }, el("h1", {}, table.title), el("div", { class: "row" }, actions, el("a", { class: "button", href: `/api/v1/studies/${id}/table.csv`, download: "study.csv" }, "Download the table"))), states,
    table.results.length > 0 && numbers.length > 0 && el("div", { class: "card" }, el("div", { class: "row" }, el("h2", {}, "Plot"), el("label", {}, "of", up), el("label", {}, "over", across)), place), means,
    el("div", { class: "card scroll" }, el("table", { class: "study" }, el("thead", {}, head), body)), curves);

  function plot() {
    clear();
    clear = () => {};
    if (!table.results.length || !numbers.length) return;
    const series = points(table, Number(across.value), Number(up.value));
    if (!series.length) return put(place, el("p", { class: "quiet" }, "Points appear as runs finish."));
    put(place);
    clear = scatter(place, table.keys[Number(across.value)], heading(table.results[Number(up.value)]), series);
  }

  /** Means over seeds, and differences from the first point. */
  function average() {
    if (!table.means.length) return put(means);
    const keys = table.keys.filter((/** @type {string} */ key) => key !== "seed");
    const differ = table.means.some((/** @type {any} */ point) => point.results.some((/** @type {any} */ one) => one.difference != null));
    /** @param {number | null} value @param {number | null} error */
    const text = (value, error) => (value == null ? "" : error ? uncertain(value, error) : number(value));
    put(means, el("div", { class: "card scroll" }, el("div", { class: "row spread" }, el("h2", {}, "Means over seeds"), el("div", { class: "row" },
      el("a", { class: "button", href: `/api/v1/studies/${id}/means.csv`, download: "study.means.csv" }, "Download the means"),
      differ && el("a", { class: "button", href: `/api/v1/studies/${id}/differences.csv`, download: "study.differences.csv" }, "Download the differences"))),
      el("p", { class: "quiet small" }, "With standard errors, which few seeds widen. Seeds count in their order, up to the first that is not finished.", differ && " Differences are those from the first row, seed by seed."),
      el("table", { class: "means" }, el("thead", {}, el("tr", {}, keys.map((/** @type {string} */ key) => el("th", { class: "number" }, key)), el("th", { class: "number" }, "seeds"),
        table.results.map((/** @type {any} */ column) => [el("th", { class: "number" }, heading(column)), differ && el("th", { class: "number" }, "difference")]))),
        el("tbody", {}, table.means.slice(0, 500).map((/** @type {any} */ point) => el("tr", {}, point.values.map((/** @type {string | null} */ value) => el("td", { class: "number" }, value ?? "")), el("td", { class: "number" }, point.seeds),
          point.results.map((/** @type {any} */ one) => [el("td", { class: "number", title: one.low == null ? "" : `95 %: ${number(one.low)} to ${number(one.high)}` }, text(one.mean, one.error)), differ && el("td", { class: "number" }, text(one.difference, one.difference_error))])))))));
  }

  /** @param {any} row @param {number} column */
  const cell = (row, column) => {
    if (column < 0) return table.rows.indexOf(row);
    if (column < table.keys.length) return numeric(row.values[column]) ?? row.values[column] ?? "";
    return row.results[column - table.keys.length] ?? Number.NaN;
  };
  function fill() {
    put(states, counts(table.states));
    const live = table.rows.filter((/** @type {any} */ row) => ["queued", "running"].includes(row.state));
    const stopped = table.rows.filter((/** @type {any} */ row) => ["stopped", "failed", "cancelled"].includes(row.state));
    put(actions, live.length > 0 && el("button", { onclick: () => all(live, "stop") }, `Stop ${live.length}`), stopped.length > 0 && el("button", { onclick: () => all(stopped, "resume") }, `Resume ${stopped.length}`),
      chosen.size > 0 && el("button", { onclick: () => go(`/compare?runs=${[...chosen].join(",")}`) }, "Compare"));
    /** @param {string} text @param {number} column */
    const sorter = (text, column) => el("th", { class: "number", "aria-sort": sorted === column ? (way > 0 ? "ascending" : "descending") : "none" },
      el("button", { class: "plain", onclick: () => { [sorted, way] = sorted === column ? [column, -way] : [column, 1]; fill(); } }, text, sorted === column ? (way > 0 ? " ▲" : " ▼") : ""));
    put(head, el("td"), el("th", {}, "Run"), el("th", {}, "State"), table.keys.map((/** @type {string} */ key, /** @type {number} */ k) => sorter(key, k)),
      table.results.map((/** @type {any} */ column, /** @type {number} */ k) => sorter(heading(column), table.keys.length + k)));
    const rows = [...table.rows].sort((a, b) => {
      const [x, y] = [cell(a, sorted), cell(b, sorted)];
      if (typeof x === "number" && typeof y === "number") return way * ((Number.isNaN(x) ? Infinity : x) - (Number.isNaN(y) ? Infinity : y)) || 0;
      return way * String(x).localeCompare(String(y));
    });
    // A table of thousands of rows is a file, not a page.
    const shown = rows.slice(0, 500);
    put(body, ...shown.map((row) => {
      const box = el("input", { type: "checkbox", checked: chosen.has(row.id), "aria-label": `Choose ${row.name}`, onchange: () => {
        if (box.checked) chosen.add(row.id); else chosen.delete(row.id);
        fill();
        lay();
      } });
      return el("tr", {}, el("td", {}, box), el("td", {}, el("a", { href: `/runs/${row.id}` }, row.name), row.problem && el("div", { class: "small bad-text" }, row.problem)), el("td", {}, state(row)),
        row.values.map((/** @type {string | null} */ value) => el("td", { class: "number" }, value ?? "")), row.results.map((/** @type {number | null} */ value, /** @type {number} */ k) => el("td", { class: "number", title: row.remarks[k] ?? "" }, value == null ? "" : row.errors[k] ? uncertain(value, row.errors[k]) : number(value), row.remarks[k] && value == null && el("span", { class: "small quiet" }, row.remarks[k]))));
    }), rows.length > shown.length && el("tr", {}, el("td", { colspan: String(3 + table.keys.length + table.results.length), class: "quiet" }, `${rows.length - shown.length} further runs are in the table to download.`)));
  }
  /** @param {any[]} rows @param {string} what */
  async function all(rows, what) {
    for (const row of rows) await post(`/runs/${row.id}/${what}`, {}).catch((error) => toast(error.message, true));
    again();
  }
  /** @type {ReturnType<typeof overlay> | null} */
  let laid = null;
  /** Time at which the charts were drawn: they follow the runs, not faster than every 5 s. */
  let drawn = 0;
  /** Charts over each other: of the chosen runs, or of the first ones that have begun. */
  async function lay() {
    const wanted = table.rows.filter((/** @type {any} */ row) => (chosen.size ? chosen.has(row.id) : row.state !== "queued")).slice(0, MOST_CURVES);
    const found = await Promise.all(wanted.map(async (/** @type {any} */ row) => ({ id: row.id, label: row.name, tables: await get(`/runs/${row.id}/tables`).catch(() => []) })));
    end();
    const runs = found.filter((run) => run.tables.length);
    laid = runs.length ? overlay(runs, laid?.column()) : null;
    end = laid?.end ?? (() => {});
    put(curves, laid?.chart);
    drawn = Date.now();
  }
  /** @type {any} */
  let waiting = null;
  async function again() {
    clearTimeout(waiting);
    waiting = null;
    table = await get(`/studies/${id}`).catch(() => table);
    fill();
    plot();
    average();
    if (Date.now() - drawn > 5000) await lay();
  }
  fill();
  plot();
  average();
  await lay();
  const ids = new Set(table.rows.map((/** @type {any} */ row) => row.id));
  // Many runs end at once: the table is read anew once a second at most.
  const deaf = listen([], (news) => {
    if (!ids.has(news.run) || waiting) return;
    if (news.kind === "state") waiting = setTimeout(again, 1000);
    else if (news.kind === "progress" && Date.now() - drawn > 5000) waiting = setTimeout(again, 1000);
  }, again);
  return () => { clearTimeout(waiting); deaf(); clear(); end(); };
}
