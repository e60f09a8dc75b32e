// The page of one run: progress, particles, charts, log, attempts, files; what can be done with it.
import { bytes, get, listen, patch, post, Problem, remove } from "./api.js";
import { box, draw } from "./chart.js";
import { choices, Charts, column } from "./charts.js";
import { ago, ask, duration, el, number, put, size, state, toast, whole } from "./dom.js";
import { go } from "./app.js";
import { money, price } from "./money.js";
import { selection, takes } from "./projects.js";
import { isShown, showFile } from "./preview.js";
import { Player } from "./player.js";
import { known, looks, uncertain } from "./statistics.js";

const LIVE = ["queued", "running", "stopping"];
const CAUSES = /** @type {Record<string, string>} */ ({
  finished: "came to its end", spot: "the machine was taken away", user: "stopped by its user", time: "the limit of time", preempted: "stopped from outside", lost: "no sign of life",
  hung: "no steps any more", disk: "too much output", memory: "too little memory", failed: "the solver failed", input: "the input is not taken", engine: "could not be started",
});

/**
 * @param {HTMLElement} main
 * @param {string} id
 * @returns {Promise<() => void>}
 */
export async function showRun(main, id) {
  let run = await get(`/runs/${id}`);
  const session = await get("/session");
  const projects = session.user === run.owner && run.writable ? await selection("none", takes) : null;
  if (projects) {
    projects.value = run.project ?? "";
    projects.onchange = () => patch(`/runs/${id}`, { project: projects.value }).then((found) => { run = { ...run, ...found }; }, (error) => toast(error.message, true));
  }
  document.title = `${run.title} · Mercury`;
  const [named, actions, life, verdict] = [el("div"), el("div", { class: "row" }), el("div"), el("div")];
  const head = el("div", { class: "card" }, el("div", { class: "row spread" }, named, actions), life, verdict);
  let verifying = 0;
  /** What the buttons of the head depend on, as text: they are made anew only where that changes. */
  let offered = "";
  const panes = /** @type {Record<string, HTMLElement>} */ ({});
  const tabs = el("div", { role: "tablist", "aria-label": "Parts of the run" });
  let tab = "Overview";
  /** @type {(() => void)[]} */
  let charts = [];
  const stage = el("div");
  const viewer = new Player(stage, run, { branch });
  const chartBox = el("div", { class: "charts" });
  const log = el("pre", { tabindex: "0", "aria-label": "Log" }, "");
  const logOf = el("select", { "aria-label": "Lines of", onchange: () => showLog() });
  const logSearch = el("input", { type: "search", "aria-label": "Search in the log", placeholder: "Search", oninput: () => showLines() });
  const attempts = el("tbody");
  const files = el("tbody");
  const pictures = el("div", { class: "gallery" });
  const chosen = el("div");
  const many = new Charts(chosen, id);
  const facts = el("div", { class: "card" });
  const values = el("div");
  const over = el("div");
  const results = el("div", { class: "card", hidden: true }, el("h2", {}, "Results"), values, over, el("p", { class: "small quiet" }, "Behind ± is one standard error."));
  /** Looks at the results that end the run. @type {import("./statistics.js").Looks[]} */
  let seen = [];
  /** @type {(() => void)[]} */
  let bands = [];

  const parts = ["Overview", "Charts", "Log", "Attempts", "Files", "Scene"];
  for (const part of parts) {
    panes[part] = el("section", { role: "tabpanel", id: `pane-${part}`, "aria-labelledby": `tab-${part}`, hidden: part !== tab });
    tabs.append(el("button", { role: "tab", id: `tab-${part}`, "aria-controls": `pane-${part}`, "aria-selected": String(part === tab), tabindex: part === tab ? "0" : "-1", onclick: () => choose(part),
      onkeydown: (/** @type {KeyboardEvent} */ event) => {
        const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
        if (step) { choose(parts[(parts.indexOf(tab) + step + parts.length) % parts.length]); /** @type {any} */ (tabs.querySelector("[aria-selected=true]")).focus(); }
      } }, part));
  }
  put(panes.Overview, el("div", { class: "columns" }, stage, el("div", {}, facts, results, el("div", { class: "card" }, chartBox))), pictures);
  put(panes.Charts, chosen);
  put(panes.Log, el("div", { class: "card" }, el("div", { class: "row" }, el("label", {}, "Lines of", logOf), logSearch), log));
  put(panes.Attempts, el("div", { class: "card scroll" }, el("table", {}, el("thead", {}, el("tr", {}, ["Number", "Began", "Lasted", "Machine", "Why it ended", "Step", session.price && "Cost"].filter(Boolean).map((text) => el("th", {}, text)))), attempts)));
  put(panes.Files, el("div", { class: "card" }, el("div", { class: "row spread" }, el("h2", {}, "Files"), el("a", { class: "button", href: `/api/v1/runs/${id}/archive`, download: "" }, "Download all (.zip)")),
    el("div", { class: "scroll" }, el("table", {}, el("thead", {}, el("tr", {}, el("th", {}, "Name"), el("th", { class: "number" }, "Size"), el("td"))), files))));
  put(panes.Scene, el("div", { class: "card" }, run.spec.set.length > 0 && el("p", {}, "Set beside it: ", run.spec.set.map((/** @type {string} */ one) => el("code", { class: "chip" }, one))), el("pre", { tabindex: "0" }, run.scene)));
  put(main, head, tabs, ...parts.map((part) => panes[part]));

  /** @param {string} part */
  function choose(part) {
    tab = part;
    for (const button of tabs.children) {
      const on = button.id === `tab-${part}`;
      button.setAttribute("aria-selected", String(on));
      button.setAttribute("tabindex", on ? "0" : "-1");
    }
    for (const [name, pane] of Object.entries(panes)) pane.hidden = name !== part;
    refresh();
  }

  /** @param {string} what @param {any} [body] */
  async function act(what, body = {}) {
    try {
      run = { ...run, ...(await post(`/runs/${id}/${what}`, body)) };
      top();
      refresh();
    } catch (error) {
      toast(error instanceof Error ? error.message : String(error), true);
    }
  }

  function top() {
    const live = LIVE.includes(run.state);
    const sooner = known(run, seen);
    const left = sooner ?? run.seconds_left;
    const share = run.of_steps ? Math.min(1, run.step / run.of_steps) : null;
    viewer.branch.hidden = !run.writable || !["finished", "stopped"].includes(run.state);
    const offers = JSON.stringify([run.state, run.writable, run.time > 0, run.title]);
    if (offers !== offered) put(actions, run.writable ? [
      ["running", "queued"].includes(run.state) && el("button", { onclick: () => act("stop") }, "Stop"),
      run.state === "stopping" && el("button", { class: "danger", onclick: async () => { if (await ask("End at once", "What was made since the last commit is lost.", "End") !== null) act("kill"); } }, "End at once"),
      ["stopped", "failed", "cancelled"].includes(run.state) && el("button", { class: "main", onclick: () => act("resume") }, "Resume"),
      !live && run.time > 0 && el("button", { onclick: async () => {
        const end = await ask("Extend", `The run has come to ${number(run.time)} s. It goes on from there.`, "Extend", { label: "New end / s", value: String(Number((run.time * 2).toPrecision(3))), type: "number" });
        if (end !== null) act("extend", { end: Number(end) });
      } }, "Extend"),
      run.state === "finished" && el("button", { onclick: verify }, "Verify"),
      el("button", { onclick: () => go(`/new?from=${id}`) }, "Clone"),
      el("button", { onclick: shareLink }, "Share"),
      !live && el("button", { class: "danger", onclick: async () => {
        if (await ask("Delete", `${run.title} with all its files. This cannot be taken back.`, "Delete") === null) return;
        await remove(`/runs/${id}`).then(() => go("/"), (error) => toast(error.message, true));
      } }, "Delete"),
    ] : [el("span", { class: "quiet" }, "to look at only")]);
    offered = offers;
    const doing = run.state === "queued" ? "waits for a free place" : run.waits ? `waits in the queue: ${run.waits}` : run.beat?.doing || "";
    put(named, el("h1", {}, run.title), el("div", { class: "row small quiet" }, state(run),
      run.label && el("a", { href: `/?label=${encodeURIComponent(run.label)}` }, run.label), run.study && el("a", { href: `/studies/${run.study}` }, "its study"), `submitted ${ago(run.created)}`, el("span", { class: "code" }, id.slice(0, 8))));
    put(life, run.unseen && live && el("p", { class: "warn-text" }, `Not seen for ${duration(run.unseen)}.`),
    !live && (run.cause ? run.cause !== "finished" : run.message) && el("p", { class: run.state === "failed" ? "bad-text" : "quiet" }, run.cause === "user" && run.message ? run.message : [CAUSES[run.cause] ?? run.cause, run.message && el("pre", {}, run.message)]),
    live && el("div", {}, el("p", { class: "row spread small" }, el("span", {}, share !== null ? `${(100 * share).toFixed(1)} % · ${number(run.time)} s of simulated time` : `${number(run.time)} s of simulated time`, doing && ` · ${doing}`),
      el("span", { class: "quiet" }, left ? `about ${duration(left)} left${sooner == null ? "" : ", until the results are known"}` : "")), el("progress", { max: 1, value: share ?? 0, "aria-label": "Progress" })));
    const bad = run.notes.filter((/** @type {any} */ note) => ["not-reproduced", "damaged"].includes(note.kind));
    put(facts, el("h2", {}, "Run"), el("dl", { class: "facts" },
      el("dt", {}, "Steps"), el("dd", {}, run.of_steps ? `${whole(run.step)} of ${whole(run.of_steps)}` : whole(run.step)),
      el("dt", {}, "Time"), el("dd", {}, `${number(run.time)} s`),
      run.particles != null && [el("dt", {}, "Particles"), el("dd", {}, whole(run.particles))],
      run.beat?.rate && live && [el("dt", {}, "Speed"), el("dd", {}, `${whole(Math.round(run.beat.rate))} particle steps/s`)],
      el("dt", {}, "Attempts"), el("dd", {}, run.epoch),
      el("dt", {}, "Threads"), el("dd", {}, run.spec.threads),
      run.ranks > 1 && [el("dt", {}, "Ranks"), el("dd", {}, run.ranks)],
      run.time_limit && [el("dt", {}, "Time limit"), el("dd", {}, duration(run.time_limit))],
      run.core_seconds > 0 && [el("dt", {}, "Spent"), el("dd", {}, `${duration(run.core_seconds)} of a core`, run.cost != null && `, ${money(run.cost, session.price)}`)],
      run.saved > 0 && [el("dt", {}, "Saved"), el("dd", {}, `${money(run.saved, session.price)} against the full price`)],
      left && live && session.price && [el("dt", {}, "Still to pay"), el("dd", {}, `about ${price(left * run.spec.threads * run.ranks, session.price)}`)],
      session.user !== run.owner && [el("dt", {}, "Owner"), el("dd", {}, run.owner)],
      projects && [el("dt", {}, "Project"), el("dd", {}, projects)],
      el("dt", {}, "Solver"), el("dd", {}, run.spec.solver)),
    bad.length > 0 && el("ul", { class: "problems" }, ...bad.map((/** @type {any} */ note) => el("li", {}, note.text))));
  }

  /** Shows whether the run was verified, until the answer is there. */
  async function showVerified() {
    const found = await get(`/runs/${id}/verification`);
    clearTimeout(verifying);
    if (found.verdict === "running") verifying = setTimeout(() => showVerified().catch((error) => toast(error.message, true)), 1000);
    const texts = /** @type {Record<string, [string, string]>} */ ({ running: ["quiet", "is being verified"], differs: ["bad-text", `Differs: ${found.message}`], unverifiable: ["warn-text", `Cannot be verified: ${found.message}`],
      verified: ["quiet", `Verified: ${number(100 * found.share)} % of the steps made again; last link `] });
    const shown = texts[found.verdict];
    put(verdict, shown && el("p", { class: `small ${shown[0]}`, role: "status" }, shown[1], found.verdict === "verified" && el("span", { class: "code", title: found.link }, found.link.slice(0, 12))));
  }

  async function verify() {
    try {
      await post(`/runs/${id}/verification`, {});
      await showVerified();
    } catch (error) {
      toast(error instanceof Error ? error.message : String(error), true);
    }
  }

  /** Submits a run that is this one up to the time that is shown. @param {number} time */
  async function branch(time) {
    const text = await ask("Branch here", `The new run is this one up to ${number(time)} s, and goes on with these changes of its scene.`, "Submit", { label: "Changes, one a line", value: "gravity = [0, 0, -1.62]", lines: 4 });
    if (text === null) return;
    try {
      const made = await post(`/runs/${id}/branch`, { at: time, set: text.split("\n").map((line) => line.trim()).filter(Boolean) });
      go(`/runs/${made.id}`);
    } catch (error) {
      const problems = error instanceof Problem ? error.problems.map((/** @type {any} */ problem) => problem.message) : [];
      toast(problems.join("; ") || (error instanceof Error ? error.message : String(error)), true);
    }
  }

  async function shareLink() {
    const days = await ask("Share", "With the link others can look at this run and fetch its files.", "Make a link", { label: "Days", value: "30", type: "number" });
    if (days === null) return;
    try {
      const made = await post(`/runs/${id}/share`, { days: Number(days) });
      const link = `${location.origin}/runs/${id}#token=${made.token}`;
      await navigator.clipboard?.writeText(link).catch(() => {});
      await ask("Link", "It is in the clipboard, where the browser allows that.", "Done", { label: "Link", value: link });
    } catch (error) {
      toast(error instanceof Error ? error.message : String(error), true);
    }
  }

  /** @type {any[]} */
  let tables = [];
  /** Whether something was drawn already. */
  let drawn = false;
  async function plot() {
    tables = await get(`/runs/${id}/tables`);
    drawn = true;
    if (tab === "Charts") return many.show(tables);
    const energies = choices(tables).filter((choice) => choice.kind === "ene" && ["traKineticEnergy", "rotKineticEnergy", "elasticEnergy"].includes(choice.column));
    if (!energies.length) return;
    const curves = await Promise.all(energies.map(async (choice) => ({ label: choice.column.replace("Energy", ""), chart: await column(id, choice) })));
    charts.forEach((end) => end());
    const one = box();
    put(chartBox, one);
    charts = [draw(one, "Energies / J", curves)];
  }

  let lines = "";
  /** Shows the lines that contain what is searched for; stays at the end, where it is there. */
  function showLines() {
    const wanted = logSearch.value.toLowerCase();
    const found = wanted ? lines.split("\n").filter((line) => line.toLowerCase().includes(wanted)).join("\n") : lines;
    const end = log.scrollTop + log.clientHeight >= log.scrollHeight - 30;
    put(log, found || (wanted && lines ? "No line has this text." : "Nothing yet."));
    if (end) log.scrollTop = log.scrollHeight;
  }
  /** The lines of an attempt as they come, or the report that the solver writes at the end. */
  async function showLog() {
    if (logOf.options.length !== run.epoch + 1) {
      const chosen = logOf.value;
      put(logOf, ...Array.from({ length: run.epoch }, (_, k) => el("option", { value: String(k + 1) }, `attempt ${k + 1}`)), el("option", { value: "" }, "the report"));
      logOf.value = chosen || (run.state === "finished" || !run.epoch ? "" : String(run.epoch));
    }
    lines = (await get(`/runs/${id}/log${logOf.value && `?attempt=${logOf.value}`}`)).text;
    showLines();
  }

  async function showAttempts() {
    const all = await get(`/runs/${id}/attempts`);
    put(attempts, ...all.map((/** @type {any} */ one) => el("tr", {}, el("td", {}, one.epoch), el("td", {}, new Date(one.started * 1000).toLocaleString()), el("td", {}, duration((one.ended ?? Date.now() / 1000) - one.started)),
      el("td", {}, one.machine || one.engine), el("td", {}, one.cause ? CAUSES[one.cause] ?? one.cause : "on its way", one.code ? ` (exit code ${one.code})` : "", one.message && el("div", { class: "small quiet" }, one.message)), el("td", { class: "number" }, one.step != null ? whole(one.step) : ""), session.price && el("td", { class: "number" }, one.cost != null ? money(one.cost, session.price) : ""))));
    if (!all.length) put(attempts, el("tr", {}, el("td", { colspan: "7", class: "quiet" }, "None yet.")));
  }

  async function showFiles() {
    const all = await get(`/runs/${id}/files`);
    const path = (/** @type {string} */ name) => `/api/v1/runs/${id}/files/${name.split("/").map(encodeURIComponent).join("/")}`;
    put(files, ...all.map((/** @type {any} */ file) => el("tr", {}, el("td", {}, el("a", { href: path(file.name), download: file.name.split("/").pop() }, file.name), file.grows && el("span", { class: "small quiet" }, " grows")), el("td", { class: "number" }, size(file.bytes)),
      el("td", {}, isShown(file) && el("button", { onclick: () => showFile(file, path(file.name)) }, "View")))));
    const shown = all.filter((/** @type {any} */ file) => file.name.endsWith(".png"));
    put(pictures, ...shown.map((/** @type {any} */ file) => el("a", { href: path(file.name), download: "" }, el("img", { src: path(file.name), alt: file.name, loading: "lazy" }))));
  }

  /** Results of the finished run: value, standard error, 95 % interval, window, and what the solver remarks. */
  async function showResults() {
    const found = (await get(`/runs/${id}/files/summary.json`)).results ?? {};
    results.hidden = Object.keys(found).length === 0;
    put(values, Object.entries(found).map(([name, one]) => el("div", { class: "result" },
      el("div", {}, el("b", {}, name), one.value == null ? el("span", { class: "bad-text" }, ` has no value: ${one.problem}`) : ` = ${one.error ? uncertain(one.value, one.error) : number(one.value)}${one.unit && one.unit !== "1" ? ` ${one.unit}` : ""}`),
      el("div", { class: "small quiet" }, el("code", {}, one.of),
        one.interval && `; 95 %: ${number(one.interval[0])} to ${number(one.interval[1])}`, one.window && `; ${number(one.window[0])} to ${number(one.window[1])} s`, one.batches && `, ${Math.floor(one.batches)} independent batches`),
      one.why_no_error && el("div", { class: "small quiet" }, `no error: ${one.why_no_error}`),
      one.value != null && one.problem && el("div", { class: "small warn-text" }, one.problem),
      one.note && el("div", { class: "small warn-text" }, one.note), one.steady === false && el("div", { class: "small warn-text" }, "The rows of the window are not steady."))));
  }

  /** Results that end the run, at each look: the band of their 95 % intervals over time, and while the run computes what is missing. */
  async function showLooks() {
    const table = tables.find((one) => one.file.endsWith(".results.csv"));
    if (!table) return;
    seen = looks(new TextDecoder().decode(await bytes(`/runs/${id}/files/${table.file.split("/").map(encodeURIComponent).join("/")}`)));
    if (!seen.length) return;
    results.hidden = false;
    const unit = (/** @type {any} */ one) => (one.unit && one.unit !== "1" ? ` ${one.unit}` : "");
    if (run.state !== "finished") put(values, seen.map((one) => el("div", { class: "result" }, el("div", {}, el("b", {}, one.name), ` = ${uncertain(one.value[one.value.length - 1], one.error)}${unit(one)}`),
      el("div", { class: "small quiet" }, `wanted: ± ${number(one.wanted)}${unit(one)}; ${one.more > 0 ? `about ${number(Number(one.more.toPrecision(2)))} s of simulated time more` : "known at this look"}`),
      !one.steady && el("div", { class: "small warn-text" }, "The rows are not steady yet."))));
    bands.forEach((end) => end());
    const boxes = seen.map(() => box());
    put(over, boxes);
    bands = seen.map((one, k) => draw(boxes[k], `${one.name}${one.unit && one.unit !== "1" ? ` / ${one.unit}` : ""}`, [{ label: "value", chart: { time: one.time, min: one.value, max: one.value } }, { label: "95 %", chart: { time: one.time, min: one.low, max: one.high } }]));
    top();
  }

  let [busy, wanted] = [false, false];
  /** Brings what is in view up to date: once more, where that was wished for meanwhile. */
  async function refresh() {
    if (busy) { wanted = true; return; }
    [busy, wanted] = [true, false];
    try {
      if (tab === "Overview") await viewer.load();
      if (tab === "Overview" || tab === "Charts") await plot();
      if (tab === "Overview") await showLooks();
      if (tab === "Log") await showLog();
      if (tab === "Attempts") await showAttempts();
      if (run.state === "finished") await showVerified();
      else put(verdict);
      if (tab === "Overview" && run.state === "finished") await showResults();
      if (tab === "Files" || (tab === "Overview" && run.state === "finished")) await showFiles();
    } catch (error) {
      if (drawn) console.info(error);
    } finally {
      busy = false;
    }
    if (wanted) refresh();
  }

  const again = async () => {
    run = await get(`/runs/${id}`).catch(() => run);
    top();
    refresh();
  };
  top();
  refresh();
  let last = 0;
  const end = listen([id], (news) => {
    if (news.kind === "progress") {
      run = { ...run, beat: news.data, step: Math.max(run.step, news.data.step), of_steps: news.data.of_steps ?? run.of_steps, time: Math.max(run.time, news.data.time), particles: news.data.particles, seconds_left: news.data.seconds_left };
      top();
      if (Date.now() - last > 4000) { last = Date.now(); refresh(); }
    } else again();
  }, again);
  return () => { end(); clearTimeout(verifying); [...charts, ...bands].forEach((stop) => stop()); many.end(); viewer.end(); };
}
