// Projects: users who share runs.
import { get, post, put as send, remove } from "./api.js";
import { ask, el, put, toast, whole } from "./dom.js";

const ROLES = ["viewer", "member", "manager"];

/**
 * @param {HTMLElement} main
 * @returns {Promise<() => void>}
 */
export async function showProjects(main) {
  document.title = "Projects · Mercury";
  const session = await get("/session");
  const list = el("div");
  const name = el("input", { required: true, maxlength: "200", placeholder: "Name", "aria-label": "Name of a new project", class: "grow" });
  const make = el("form", { class: "row", onsubmit: async (/** @type {Event} */ event) => {
    event.preventDefault();
    await act(() => post("/projects", { name: name.value }));
    name.value = "";
  } }, name, el("button", { class: "main" }, "New project"));
  put(main, el("h1", {}, "Projects"),
    el("p", { class: "quiet" }, "The members of a project see its runs. A viewer looks, fetches and clones; a member also submits, stops, resumes, extends and deletes; a manager also chooses the members. A run counts on the limits of its owner."),
    !session.read_only && el("div", { class: "card" }, make), list);

  /** @param {() => Promise<any>} what */
  async function act(what) {
    await what().catch((error) => toast(error instanceof Error ? error.message : String(error), true));
    await load();
  }

  /** @param {any} project */
  function card(project) {
    const manages = project.role === "manager" && !session.read_only;
    const path = `/projects/${project.id}`;
    const of = (/** @type {string} */ user) => `${path}/members/${encodeURIComponent(user)}`;
    const added = el("input", { required: true, placeholder: "Name of a user", "aria-label": `New member of ${project.name}` });
    const role = el("select", { "aria-label": "Role" }, ROLES.map((word) => el("option", { value: word }, word)));
    role.value = "member";
    const rows = project.members.map((/** @type {any} */ member) => {
      const chosen = el("select", { "aria-label": `Role of ${member.name}`, disabled: !manages, onchange: () => act(() => send(of(member.name), { role: chosen.value })) },
        ROLES.map((word) => el("option", { value: word }, word)));
      chosen.value = member.role;
      const leaves = member.name === session.user;
      return el("tr", {}, el("td", {}, member.name), el("td", {}, chosen),
        el("td", { class: "number" }, (manages || leaves) && !session.read_only && el("button", { onclick: () => act(() => remove(of(member.name))) }, leaves ? "Leave" : "Remove")));
    });
    return el("div", { class: "card" },
      el("div", { class: "row spread" }, el("h2", {}, project.name), el("div", { class: "row" },
        el("a", { class: "button", href: `/?project=${project.id}` }, project.runs === 1 ? "1 run" : `${whole(project.runs)} runs`),
        manages && el("button", { class: "danger", onclick: async () => {
          if (await ask("Remove", `The project ${project.name}. Its runs stay with their owners.`, "Remove") !== null) act(() => remove(path));
        } }, "Remove"))),
      el("div", { class: "scroll" }, el("table", {}, el("thead", {}, el("tr", {}, el("th", {}, "Member"), el("th", {}, "Role"), el("td"))), el("tbody", {}, rows))),
      manages && el("form", { class: "row", onsubmit: (/** @type {Event} */ event) => {
        event.preventDefault();
        act(() => send(of(added.value.trim()), { role: role.value }));
      } }, added, role, el("button", {}, "Add")));
  }

  async function load() {
    const projects = await get("/projects");
    put(list, projects.length ? projects.map(card) : el("p", { class: "empty" }, "You are in no project yet."));
  }
  await load();
  return () => {};
}

/**
 * A selection among one's projects; null where there are none.
 * @param {string} none what the first choice is called
 * @param {(project: any) => boolean} fits
 * @returns {Promise<HTMLSelectElement | null>}
 */
export async function selection(none, fits = () => true) {
  const projects = (await get("/projects")).filter(fits);
  if (!projects.length) return null;
  return el("select", { "aria-label": "Project" }, el("option", { value: "" }, none),
    projects.map((/** @type {any} */ project) => el("option", { value: project.id }, project.name)));
}

/** Whether one may submit to a project. @param {any} project */
export const takes = (project) => project.role !== "viewer";
