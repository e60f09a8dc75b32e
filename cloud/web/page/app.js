// The page: which part is shown at which path.
import { get, post, Problem } from "./api.js";
import { ask, duration, el, put, size, toast } from "./dom.js";
import { showAccount } from "./account.js";
import { showList } from "./list.js";
import { showNew } from "./new.js";
import { showRun } from "./run.js";
import { showCompare } from "./compare.js";
import { showProjects } from "./projects.js";
import { showStudies, showStudy } from "./studies.js";

const main = /** @type {HTMLElement} */ (document.getElementById("main"));
/** Ends what the part that is shown has begun. @type {() => void} */
let leave = () => {};
/** @type {any} */
let session = null;

/** Goes to a path of the page. @param {string} path */
export function go(path) {
  history.pushState(null, "", path);
  show();
  scrollTo(0, 0);
}

async function show() {
  leave();
  leave = () => {};
  const { pathname, searchParams } = new URL(location.href);
  for (const link of document.querySelectorAll("nav a")) {
    if (link.getAttribute("href") === pathname) link.setAttribute("aria-current", "page");
    else link.removeAttribute("aria-current");
  }
  try {
    const run = pathname.match(/^\/runs\/([0-9a-f]{32})$/);
    const study = pathname.match(/^\/studies\/([0-9a-f]{32})$/);
    if (run) leave = await showRun(main, run[1]);
    else if (pathname === "/studies") leave = await showStudies(main, searchParams);
    else if (study) leave = await showStudy(main, study[1]);
    else if (pathname === "/account") leave = await showAccount(main);
    else if (pathname === "/projects") leave = await showProjects(main);
    else if (pathname === "/new") leave = await showNew(main, searchParams.get("from"));
    else if (pathname === "/compare") leave = await showCompare(main, (searchParams.get("runs") ?? "").split(",").filter(Boolean));
    else if (pathname === "/" || pathname === "/index.html") leave = await showList(main, searchParams);
    else nothing(pathname);
  } catch (error) {
    if (error instanceof Problem && error.status === 401) return logIn();
    put(main, el("div", { class: "card empty" }, el("h1", {}, "That did not work"), el("p", {}, String(error instanceof Error ? error.message : error)),
      el("a", { class: "button", href: "/" }, "All runs")));
  }
}

/** Says that there is no such page. @param {string} path */
function nothing(path) {
  document.title = "No such page · Mercury";
  put(main, el("div", { class: "card empty" }, el("h1", {}, "No such page"), el("p", {}, "This server has no page ", el("code", {}, path), "."),
    el("a", { class: "button", href: "/" }, "All runs")));
}

/** Says above the page that the server is away, or that the session is over. */
addEventListener("server", (event) => {
  const how = /** @type {CustomEvent} */ (event).detail;
  const banner = /** @type {HTMLElement} */ (document.getElementById("banner"));
  const over = how === "over" && session !== null;
  banner.hidden = how !== "away" && !over;
  if (how === "away") put(banner, "The server does not respond. What is shown may be old; the page tries again by itself.");
  else if (over) put(banner, "Your session is over. ", el("a", { href: "/", onclick: () => location.reload() }, "Log in again"), ".");
});

function logIn() {
  document.title = "Log in · Mercury";
  const name = el("input", { autocomplete: "username", required: true, class: "grow" });
  const password = el("input", { type: "password", autocomplete: "current-password", required: true, class: "grow" });
  const form = el("form", { class: "card", onsubmit: async (/** @type {Event} */ event) => {
    event.preventDefault();
    await begin({ name: name.value, password: password.value });
  } }, el("h1", {}, "Log in"),
  el("p", { class: "quiet" }, "On a laptop, open the link that ", el("code", {}, "mercury-cloud serve"), " prints."),
  el("p", {}, el("label", {}, "Name", name)), el("p", {}, el("label", {}, "Password", password)), el("button", { class: "main" }, "Log in"));
  put(main, form);
}

/** @param {any} body */
async function begin(body) {
  try {
    session = await post("/session", body);
    known();
    show();
  } catch (error) {
    toast(error instanceof Error ? error.message : String(error), true);
    if (!session) logIn();
  }
}

/** Whether this browser has had a session. */
function remembered() {
  try { return localStorage.getItem("session") !== null; } catch { return true; }
}

function known() {
  try { localStorage.setItem("session", "1"); } catch { /* a browser that keeps nothing */ }
  const place = /** @type {HTMLElement} */ (document.getElementById("who"));
  const { disk, most_disk: most, core_seconds: spent, most_core_seconds: granted } = session.usage;
  // A link to a run shows nothing of its owner.
  if (!session.user) return put(place, `a run that is shared · solver ${session.solver}`);
  put(place, `${session.user} · ${session.cores[0]} of ${session.cores[1]} cores free · ${size(disk)}${most == null ? "" : ` of ${size(most)}`}${granted == null ? "" : ` · ${duration(Math.max(0, granted - spent)) || "0 s"} of a core left`} · solver ${session.solver}`);
}

document.addEventListener("click", (event) => {
  const link = event.target instanceof Element ? event.target.closest("a") : null;
  const plain = event.button === 0 && !event.metaKey && !event.ctrlKey && !event.shiftKey;
  if (link && plain && link.origin === location.origin && !link.hasAttribute("download") && !link.target && !link.pathname.startsWith("/api/") && !link.hash) {
    event.preventDefault();
    go(link.pathname + link.search);
    main.focus();
  }
});
addEventListener("popstate", show);
// Charts and walls have the colours of the scheme in which they were drawn.
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => show());

const token = new URLSearchParams(location.hash.slice(1)).get("token");
if (token) {
  history.replaceState(null, "", location.pathname + location.search);
  // Only where this browser had a session before: a question without one is an error in the console.
  session = remembered() ? await get("/session").catch(() => null) : null;
  const who = session?.user || "the guest of another run";
  // A link from elsewhere must not make one work as another user without a word.
  if (session && await ask("Log in by this link?", `You are logged in as ${who}. The link replaces that session.`, "Log in by the link") === null) {
    known();
    show();
  } else await begin({ token });
} else {
  try {
    session = await get("/session");
    known();
  } catch { /* shown below */ }
  show();
}
