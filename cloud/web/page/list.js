// The list of runs.
import { get, listen, post, remove } from "./api.js";
import { ago, ask, duration, el, number, put, state, toast } from "./dom.js";
import { go } from "./app.js";
import { selection } from "./projects.js";

const LIVE = ["queued", "running", "stopping"];

/**
 * @param {HTMLElement} main
 * @param {URLSearchParams} wanted
 * @returns {Promise<() => void>}
 */
export async function showList(main, wanted) {
  document.title = "Runs · Mercury";
  const chosen = new Set();
  const rows = el("tbody");
  const counts = el("div", { class: "row small quiet" });
  const more = el("div", { class: "row" });
  const actions = el("div", { class: "row" });
  const text = el("input", { type: "search", placeholder: "Search titles and labels", "aria-label": "Search", value: wanted.get("text") ?? "", class: "grow" });
  const only = el("select", { "aria-label": "State" }, el("option", { value: "" }, "All states"),
    ["queued", "running", "stopping", "stopped", "finished", "failed", "cancelled"].map((word) => el("option", { value: word }, word)));
  only.value = wanted.get("state") ?? "";
  const label = wanted.get("label");
  const project = await selection("My runs");
  if (project) project.value = wanted.get("project") ?? "";
  /** @type {Map<string, {run: any, row: HTMLElement}>} */
  const shown = new Map();

  put(main,
    el("div", { class: "row spread" }, el("h1", {}, label ? `Runs of ${label}` : "Runs"), el("a", { class: "button main", href: "/new" }, "New run")),
    el("div", { class: "card" }, el("div", { class: "row" }, text, only, project, actions), counts,
      el("div", { class: "scroll" }, el("table", {}, el("thead", {}, el("tr", {},
        el("td"), el("th", {}, "Run"), el("th", {}, "State"), el("th", { class: "wide" }, "Progress"), el("th", { class: "number wide" }, "Attempts"), el("th", { class: "number wide" }, "Submitted"))), rows)), more));

  const acts = () => {
    const ids = [...chosen].filter((id) => shown.has(id));
    const live = ids.filter((id) => LIVE.includes(shown.get(id)?.run.state));
    put(actions,
      ids.length >= 1 && ids.length <= 20 && el("button", { onclick: () => go(`/compare?runs=${ids.join(",")}`) }, "Compare"),
      live.length > 0 && el("button", { onclick: () => all(live, (id) => post(`/runs/${id}/stop`, {})) }, `Stop ${live.length}`),
      ids.length > 0 && live.length === 0 && el("button", { class: "danger", onclick: async () => {
        if (await ask("Delete", `${ids.length} runs with all their files. This cannot be taken back.`, "Delete") !== null) all(ids, (id) => remove(`/runs/${id}`));
      } }, `Delete ${ids.length}`));
  };
  /** @param {string[]} ids @param {(id: string) => Promise<any>} act */
  const all = async (ids, act) => {
    for (const id of ids) await act(id).catch((error) => toast(error.message, true));
    chosen.clear();
    load();
  };

  /** @param {any} run */
  const fill = (run) => {
    const share = run.of_steps ? Math.min(1, run.step / run.of_steps) : null;
    const box = el("input", { type: "checkbox", checked: chosen.has(run.id), "aria-label": `Choose ${run.title}`, onchange: () => {
      if (box.checked) chosen.add(run.id); else chosen.delete(run.id);
      acts();
    } });
    const live = LIVE.includes(run.state);
    return [
      el("td", {}, box),
      el("td", {}, el("a", { href: `/runs/${run.id}` }, run.title), el("div", { class: "small quiet" },
        run.label && el("a", { href: `/?label=${encodeURIComponent(run.label)}` }, run.label), run.label && " ", el("span", { class: "code" }, run.id.slice(0, 8)), project?.value && ` ${run.owner}`)),
      el("td", {}, state(run), run.cause && run.cause !== run.state && run.cause !== "user" && el("div", { class: "small quiet" }, run.cause)),
      el("td", { class: "wide" }, share !== null && run.state !== "finished" && el("progress", { max: 1, value: share, "aria-label": "Progress" }),
        el("div", { class: "small quiet" }, `${number(run.time)} s`, run.seconds_left && live ? ` · ${duration(run.seconds_left)} left` : "")),
      el("td", { class: "number wide" }, run.epoch),
      el("td", { class: "number wide small" }, ago(run.created)),
    ];
  };
  /** @param {any} run */
  const update = (run) => {
    const known = shown.get(run.id);
    if (!known) return;
    known.run = run;
    put(known.row, ...fill(run));
  };

  let after = "";
  const load = async () => {
    const query = new URLSearchParams();
    for (const [name, value] of [["text", text.value], ["state", only.value], ["label", label ?? ""], ["project", project?.value ?? ""], ["after", after]]) if (value) query.set(name, value);
    const page = await get(`/runs?${query}`);
    if (!after) { shown.clear(); put(rows); }
    for (const run of page.runs) {
      const row = el("tr", {}, ...fill(run));
      shown.set(run.id, { run, row });
      rows.append(row);
    }
    put(counts, Object.entries(page.states).map(([word, count]) => el("span", {}, `${count} ${word}`)));
    put(more, page.after && el("button", { onclick: () => { after = page.after; load(); } }, "Older runs"));
    if (shown.size === 0) {
      rows.append(el("tr", {}, el("td", { colspan: "6", class: "empty" }, el("p", {}, Object.keys(page.states).length ? "No run fits." : "Nothing here yet."),
        el("a", { class: "button main", href: "/new" }, "Start from a template"))));
    }
    after = "";
    acts();
  };
  /** @type {any} */
  let typing;
  text.oninput = () => { clearTimeout(typing); typing = setTimeout(load, 250); };
  only.onchange = load;
  if (project) project.onchange = load;
  await load();
  const end = listen([], (news) => {
    const known = shown.get(news.run);
    if (news.kind === "progress" && known) update({ ...known.run, ...news.data, id: known.run.id });
    else if (news.kind === "state" && known) update({ ...known.run, state: news.data.state });
    else if (news.kind === "state" && news.data.title) load();
    acts();
  }, load);
  return () => { clearTimeout(typing); end(); };
}
