// A new run: a template, its text with the solver's own problems at their places, files, forecast, Submit.
import { get, post, Problem, upload } from "./api.js";
import { ask, duration, el, put, size, toast, whole } from "./dom.js";
import { go } from "./app.js";
import { price } from "./money.js";
import { selection, takes } from "./projects.js";
import { suggest } from "./suggest.js";
import { Viewer } from "./viewer.js";

/**
 * @param {HTMLElement} main
 * @param {string | null} from a run to start from
 * @returns {Promise<() => void>}
 */
export async function showNew(main, from) {
  document.title = "New run · Mercury";
  const templates = await get("/templates");
  const session = await get("/session");
  const project = await selection("none", takes);
  let name = "scene.toml";
  /** @type {Record<string, string>} */
  let files = {};
  /** @type {any} */
  let plan = null;
  let ended = false;

  const gutter = el("div", { class: "gutter code", "aria-hidden": "true" });
  const text = el("textarea", { class: "code", spellcheck: false, autocapitalize: "off", autocomplete: "off", "aria-label": "Scene", "aria-describedby": "problems" });
  const editor = el("div", { class: "editor" }, gutter, text);
  const help = el("p", { class: "small quiet help", "aria-live": "polite" });
  suggest(editor, text, help, () => !name.endsWith(".json"));
  const problems = el("ul", { class: "problems", id: "problems", "aria-live": "polite" });
  const facts = el("div");
  const title = el("input", { class: "grow", placeholder: "as in the scene", maxlength: "200" });
  const label = el("input", { class: "grow", placeholder: "none", maxlength: "100" });
  const sets = el("textarea", { class: "code", rows: 2, spellcheck: false, placeholder: "time.end = 2", "aria-label": "Settings that replace values of the scene" });
  const threads = el("input", { type: "number", min: "1", max: "1024", value: "1" });
  const ranks = el("input", { type: "number", min: "1", max: String(session.ranks), value: "1" });
  /** Threads of a rank, and ranks, of what is submitted. */
  const needs = () => ({ threads: Number(threads.value) || 1, ranks: (session.ranks > 1 && Number(ranks.value)) || 1 });
  const cores = () => needs().threads * needs().ranks;
  const hours = el("input", { type: "number", min: "0", step: "any", placeholder: "none", "aria-describedby": "hours-help" });
  const sweep = el("textarea", { class: "code", rows: 3, spellcheck: false, placeholder: "materials.bead.tangential.friction = 0.1, 0.3, 0.5\nseed = 1..4/4", "aria-label": "Keys and their values" });
  const results = el("textarea", { class: "code", rows: 2, spellcheck: false, placeholder: "height = max(particles.z)", "aria-label": "Results" });
  const document_ = el("textarea", { class: "code", rows: 12, spellcheck: false, "aria-label": "Study file" });
  const grid = el("div", {}, el("p", { class: "small quiet" }, "A key and its values in each line; several keys make a grid. ", el("code", {}, "0..0.5/6"), " are six values."), sweep,
    el("p", { class: "small quiet" }, "Results are columns of the table: a name, and what it is, in each line."), results);
  const filed = el("div", { hidden: true }, el("p", { class: "small quiet" }, "As ", el("code", {}, "mercury-solve study.toml"), " takes it. Its scene is the one beside."), document_);
  const verdict = el("p", { class: "small", "aria-live": "polite" });
  const toFile = el("button", { onclick: () => { filed.hidden = !filed.hidden; grid.hidden = !filed.hidden; toFile.textContent = filed.hidden ? "From a file instead" : "From a grid instead"; if (!filed.hidden && !document_.value) document_.value = draft(); studied(0); } }, "From a file instead");
  const study = el("details", {}, el("summary", {}, "A study: many runs of this scene"), grid, filed, el("div", { class: "row" }, toFile), verdict);
  const settings = el("details", {}, el("summary", {}, "Settings: values other than in the scene"), el("p", { class: "small quiet" }, "A key and its value in each line, as ", el("code", {}, "--set"), " takes them."), sets);
  const submit = el("button", { class: "main", onclick: send }, "Submit");
  const chips = el("div", { class: "chips" });
  const picker = el("input", { type: "file", multiple: true, hidden: true, onchange: () => add([...(picker.files ?? [])]) });
  const drop = el("div", { class: "drop" }, el("div", { class: "row spread" }, el("span", {}, "A scene, and files that it names: surfaces (STL, OBJ), tables (CSV), clumps."),
    el("button", { onclick: () => picker.click() }, "Add files"), picker), chips);
  drop.addEventListener("dragover", (/** @type {DragEvent} */ event) => { event.preventDefault(); drop.classList.add("over"); });
  drop.addEventListener("dragleave", () => drop.classList.remove("over"));
  drop.addEventListener("drop", (/** @type {DragEvent} */ event) => {
    event.preventDefault();
    drop.classList.remove("over");
    add([...(event.dataTransfer?.files ?? [])]);
  });
  const choices = templates.map((/** @type {any} */ template) => el("button", { "aria-pressed": "false", onclick: () => choose(template) }, el("b", {}, template.name), el("span", { class: "small quiet" }, template.title)));
  const preview = el("div");
  const viewer = new Viewer(preview, { height: "16rem" });

  put(main, el("h1", {}, "New run"),
    el("p", { class: "quiet" }, "Start from a scene, change it, and submit. It is checked while you type."),
    el("div", { class: "templates" }, ...choices),
    el("div", { class: "columns" },
      el("div", {}, editor, help, drop),
      el("div", {}, el("div", { class: "card stays" }, facts, problems), el("div", { class: "card" },
        el("h2", {}, "Submit"), el("div", { class: "form" }, el("label", {}, "Title", title), el("label", {}, "Label", label), el("label", {}, "Threads", threads), session.ranks > 1 && el("label", {}, "Ranks", ranks), el("label", {}, "Time limit / h", hours), project && el("label", {}, "Project", project)),
        settings, study,
        el("p", { class: "small quiet", id: "hours-help" }, "At its time limit a run stops with a checkpoint, and can be resumed."),
        el("div", { class: "row" }, submit, el("button", { onclick: trial }, "How long?"))),
      el("div", { class: "card" }, el("h2", {}, "Preview"), preview))));

  function scene() {
    return { name, text: text.value, files, set: linesOf(sets.value).map(tight) };
  }

  /** Where the draft is kept in this browser: what is typed survives a reload, Back, and a change of light and dark. */
  const draftKey = `draft:${session.user}`;
  /** Belongs to what is submitted: the same draft sent again is the same run. */
  let key = crypto.randomUUID();
  let sent = false;
  const fields = { text, title, label, sets, threads, ranks, hours, sweep, results, document: document_ };

  /** Keeps the draft; what was changed is another run. */
  function keep() {
    if (sent) return;
    key = crypto.randomUUID();
    const values = Object.fromEntries(Object.entries(fields).map(([word, field]) => [word, field.value]));
    const kept = { from: from ?? null, name, files, values, project: project?.value ?? "", key, study: study.open, filed: !filed.hidden };
    // A browser that keeps nothing still submits.
    try { localStorage.setItem(draftKey, JSON.stringify(kept)); } catch { /* full, or forbidden */ }
  }

  function forget() {
    sent = true;
    try { localStorage.removeItem(draftKey); } catch { /* as above */ }
  }

  /** Puts the draft of this browser back. @returns {boolean} whether there is one */
  function restore() {
    /** @type {any} */
    let kept = null;
    try { kept = JSON.parse(localStorage.getItem(draftKey) ?? "null"); } catch { /* as above */ }
    if (!kept || (from && kept.from !== from)) return false;
    ({ name, files, key } = kept);
    for (const [word, field] of Object.entries(fields)) field.value = kept.values[word] ?? "";
    if (project) project.value = kept.project;
    settings.open = sets.value !== "";
    study.open = kept.study;
    if (kept.filed) toFile.click();
    named();
    changed(0);
    return true;
  }

  /** Takes a template, and asks where that loses a text. @param {any} template */
  async function choose(template) {
    const edited = text.value.trim() !== "" && !templates.some((/** @type {any} */ one) => one.text === text.value);
    if (edited && await ask("Replace the scene?", "The text of this draft is lost.", "Replace") === null) return;
    use(template);
    keep();
  }

  /** @param {any} template */
  function use(template) {
    name = template.scene;
    files = { ...template.files };
    text.value = template.text;
    choices.forEach((/** @type {HTMLElement} */ choice, /** @type {number} */ k) => choice.setAttribute("aria-pressed", String(templates[k] === template)));
    named();
    changed(0);
  }

  function named() {
    put(chips, ...Object.keys(files).map((file) => el("span", { class: "chip" }, file, el("button", { "aria-label": `Remove ${file}`, onclick: () => { delete files[file]; named(); changed(0); keep(); } }, "×"))));
  }

  /** Lines that are not empty. @param {string} text */
  const linesOf = (text) => text.split("\n").map((line) => line.trim()).filter((line) => line && !line.startsWith("#"));
  /** `a = b` as `a=b`. @param {string} line */
  const tight = (line) => line.replace(/\s*=\s*/, "=");

  /** A study file that says what the grid says. */
  function draft() {
    const quoted = (/** @type {string} */ value) => JSON.stringify(value);
    const pairs = (/** @type {string} */ text) => linesOf(text).map((line) => tight(line).split(/=(.*)/s).slice(0, 2));
    const keys = pairs(sweep.value).map(([key, values]) => `${quoted(key)} = ${quoted(values ?? "")}`);
    const what = pairs(results.value).map(([name, value]) => `${name} = ${quoted(value ?? "")}`);
    return `[study]\nscene = ${quoted(name)}\n\n[study.sweep]\n${keys.join("\n") || "seed = [1, 2, 3]"}\n\n[study.results]\n${what.join("\n")}\n`;
  }

  /** The study that is asked for, or null. */
  function asked() {
    if (!study.open) return null;
    const base = { scene: scene(), ...needs(), result: filed.hidden ? linesOf(results.value).map(tight) : [] };
    if (!filed.hidden) return document_.value.trim() ? { base, file: document_.value } : null;
    const sweeps = linesOf(sweep.value).map(tight);
    return sweeps.length ? { base, sweep: sweeps } : null;
  }

  /** @type {any} */
  let later;
  /** @type {AbortController | null} */
  let counting = null;
  /** @param {number} wait */
  function studied(wait) {
    clearTimeout(later);
    later = setTimeout(count, wait);
  }
  /** Says how many runs the study has, or what is wrong with it. */
  async function count() {
    counting?.abort();
    counting = new AbortController();
    const body = asked();
    submit.textContent = "Submit";
    if (!body) return put(verdict);
    try {
      const found = await post("/studies/check", body, { signal: counting.signal });
      verdict.className = found.problems.length ? "small bad-text" : "small good";
      const many = found.runs.length === 1 ? "1 run" : `${whole(found.runs.length)} runs`;
      put(verdict, found.problems.length ? found.problems.slice(0, 5).map((/** @type {any} */ problem) => el("div", {}, problem.key && [el("code", {}, problem.key), " "], problem.message, problem.help && el("div", { class: "quiet" }, problem.help)))
        : `${many}: ${found.runs.slice(0, 4).join(", ")}${found.runs.length > 4 ? " …" : ""}`);
      if (!found.problems.length) submit.textContent = `Submit ${many}`;
    } catch (error) {
      if (error instanceof DOMException) return;
      verdict.className = "small bad-text";
      put(verdict, error instanceof Error ? error.message : String(error));
    }
  }
  for (const field of [sweep, results, document_]) field.addEventListener("input", () => studied(300));
  study.addEventListener("toggle", () => studied(0));

  /** @param {File[]} added */
  async function add(added) {
    // Of a scene that comes with its files, those stay that have been taken before it.
    /** @type {Record<string, string>} */
    const sent_along = {};
    for (const file of added) {
      try {
        // A study file is no file of the scene.
        if (/\.(toml|json)$/.test(file.name) && file.size < 1e6) {
          const content = await file.text();
          if (/^\s*\[study|"study"\s*:/m.test(content)) {
            document_.value = content;
            study.open = true;
            if (filed.hidden) toFile.click();
            studied(0);
            continue;
          }
          // A scene has a time; the files that it names have none.
          if (/^\s*\[time\]|^\s*time\.\w+\s*=|"time"\s*:/m.test(content)) {
            const edited = text.value.trim() !== "" && !templates.some((/** @type {any} */ one) => one.text === text.value);
            if (edited && await ask("Replace the scene?", `The text of this draft is lost; ${file.name} takes its place.`, "Replace") === null) continue;
            use({ scene: file.name.replace(/[^A-Za-z0-9._-]/g, "_").replace(/^[.-]+/, ""), text: content, files: sent_along });
            continue;
          }
        }
        // Names are flat and plain; others would be refused.
        const plain = file.name.replace(/[^A-Za-z0-9._-]/g, "_").replace(/^[.-]+/, "");
        files[plain] = sent_along[plain] = await upload(file);
        if (plain !== file.name) toast(`${file.name} is called ${plain} here`);
      } catch (error) {
        toast(`${file.name}: ${error instanceof Error ? error.message : error}`, true);
      }
    }
    named();
    changed(0);
    keep();
  }

  /** Lines with problems. @type {Set<number>} */
  let marked = new Set();
  function lines() {
    const count = text.value.split("\n").length;
    const parts = [];
    let run = "";
    for (let k = 1; k <= count; k += 1) {
      if (marked.has(k)) {
        if (run) parts.push(run);
        run = "";
        parts.push(el("span", { class: "bad" }, k));
      } else run += `${k}\n`;
    }
    put(gutter, ...parts, run, "\n\n");
    gutter.scrollTop = text.scrollTop;
  }
  text.addEventListener("scroll", () => { gutter.scrollTop = text.scrollTop; });

  /** @param {any} problem */
  function place(problem) {
    const before = text.value.split("\n").slice(0, problem.line - 1).join("\n").length + (problem.line > 1 ? 1 : 0);
    const line = text.value.split("\n")[problem.line - 1] ?? "";
    const at = before + Math.min(line.length, Math.max(0, (problem.column ?? 1) - 1));
    const end = problem.end_line === problem.line && problem.end_column > problem.column ? at + problem.end_column - problem.column : before + line.length;
    text.focus();
    text.setSelectionRange(at, end);
    text.scrollTop = Math.max(0, (problem.line - 6) * 19.5);
  }

  /** @param {any[]} found */
  function tell(found) {
    marked = new Set(found.filter((problem) => problem.line && (!problem.file || problem.file === name)).map((problem) => problem.line));
    put(problems, ...found.map((problem) => el("li", {},
      problem.line ? el("button", { onclick: () => place(problem) }, `${problem.file && problem.file !== name ? `${problem.file} ` : ""}line ${problem.line}`) : null,
      problem.line ? ": " : "", problem.set && ["setting ", el("code", {}, problem.set), ": "], !problem.set && problem.key && [el("code", {}, problem.key), " "], problem.message, problem.help && el("div", { class: "small quiet" }, problem.help))));
    lines();
  }

  /** @type {any} */
  let timer;
  /** @type {AbortController | null} */
  let asking = null;
  /** @param {number} wait */
  function changed(wait) {
    lines();
    clearTimeout(timer);
    timer = setTimeout(check, wait);
  }
  async function check() {
    asking?.abort();
    asking = new AbortController();
    const checked = scene();
    try {
      const found = await post("/check", { scene: checked }, { signal: asking.signal });
      plan = found.plan;
      tell(found.problems);
      forecast(found);
      if (plan && !found.problems.length) look(checked, asking.signal);
    } catch (error) {
      if (error instanceof DOMException) return;
      tell(error instanceof Problem && error.problems.length ? error.problems : [{ message: error instanceof Error ? error.message : String(error) }]);
    }
  }

  /** Shows the beginning of a scene that was checked. @param {any} checked @param {AbortSignal} signal */
  async function look(checked, signal) {
    try {
      const seen = await post("/preview", { scene: checked }, { signal });
      if (!ended) viewer.still(seen);
    } catch { /* a scene without a preview can still run */ }
  }

  /** @param {any} found */
  function forecast(found) {
    submit.disabled = found.problems.length > 0;
    if (found.unchecked) return put(facts, el("h2", {}, "Check"), el("p", { class: "warn-text" }, "not checked: the scene is too large"), el("p", { class: "small quiet" }, found.unchecked));
    if (!plan) return put(facts, el("h2", {}, "Check"), el("p", { class: "bad-text" }, `${found.problems.length === 1 ? "1 problem" : `${found.problems.length} problems`}`));
    /** Least and most, in s. @type {[number, number] | null} */
    const time = plan.trial?.seconds ?? null;
    put(facts, el("h2", {}, "Check"), el("p", { class: found.problems.length ? "bad-text" : "good" }, found.problems.length ? "cannot run" : "can run"),
      el("dl", { class: "facts" },
        el("dt", {}, "Particles"), el("dd", {}, plan.particles?.expected ? `about ${whole(Math.round(plan.particles.expected))}` : "none"),
        el("dt", {}, "Steps"), el("dd", {}, plan.time?.steps ? whole(plan.time.steps) : "–"),
        el("dt", {}, "Time step"), el("dd", {}, plan.time ? `${plan.time.step.toPrecision(3)} s` : "–"),
        el("dt", {}, "Memory"), el("dd", {}, size(plan.memory?.at_most)),
        el("dt", {}, "Disk"), el("dd", {}, size(plan.disk?.bytes)),
        time && el("dt", {}, "Time"), time && el("dd", {}, duration(time[0]) === duration(time[1]) ? duration(time[0]) : `${duration(time[0])} to ${duration(time[1])}`),
        time && session.price && [el("dt", {}, "Cost"), el("dd", {}, `about ${price(time[1] * cores(), session.price)} at the most`)]),
      plan.warnings?.length > 0 && el("ul", { class: "warn-text" }, ...plan.warnings.map((/** @type {any} */ warning) => el("li", {}, typeof warning === "string" ? warning : warning.message ?? JSON.stringify(warning)))));
  }

  async function trial() {
    toast("Making the first steps …");
    try {
      const found = await post("/check", { scene: scene(), trial: true });
      plan = found.plan;
      tell(found.problems);
      forecast(found);
    } catch (error) {
      toast(error instanceof Error ? error.message : String(error), true);
    }
  }

  async function send() {
    submit.disabled = true;
    /** @type {any} */
    const body = { scene: scene(), ...needs() };
    if (title.value.trim()) body.title = title.value.trim();
    if (Number(hours.value) > 0) body.time_limit = 3600 * Number(hours.value);
    if (label.value.trim()) body.label = label.value.trim();
    if (project?.value) body.project = project.value;
    const many = asked();
    try {
      if (many) {
        const made = await post("/studies", { ...many, base: { ...body, result: many.base.result } }, { headers: { "idempotency-key": key } });
        forget();
        go(`/studies/${made.id}`);
      } else {
        const run = await post("/runs", body, { headers: { "idempotency-key": key } });
        forget();
        go(`/runs/${run.id}`);
      }
    } catch (error) {
      submit.disabled = false;
      if (error instanceof Problem && error.problems.length) tell(error.problems);
      toast(error instanceof Error ? error.message : String(error), true);
    }
  }

  text.addEventListener("input", () => { changed(300); studied(600); });
  sets.addEventListener("input", () => { changed(300); studied(600); });
  for (const field of [...Object.values(fields), ...(project ? [project] : [])]) field.addEventListener("input", keep);
  if (restore()) {
    toast("This is the draft that you left.");
  } else if (from) {
    const submitted = await post(`/runs/${from}/clone`, {});
    name = submitted.scene.name;
    files = submitted.scene.files;
    text.value = submitted.scene.text;
    title.value = submitted.title ?? "";
    label.value = submitted.label ?? "";
    if (project) project.value = submitted.project ?? "";
    threads.value = String(submitted.threads);
    ranks.value = String(submitted.ranks);
    hours.value = submitted.time_limit ? String(submitted.time_limit / 3600) : "";
    sets.value = submitted.scene.set.join("\n");
    settings.open = sets.value !== "";
    named();
    changed(0);
  } else use(templates[0]);
  return () => { ended = true; clearTimeout(timer); clearTimeout(later); asking?.abort(); counting?.abort(); viewer.end(); };
}
