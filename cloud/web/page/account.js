// The account: sessions, tokens, links to runs, the web hook; for administrators users.
import { get, post, put as send, remove } from "./api.js";
import { ago, ask, duration, el, put, size, toast } from "./dom.js";

const day = (/** @type {number} */ unix) => new Date(1000 * unix).toLocaleDateString("en");

/**
 * @param {HTMLElement} main
 * @returns {Promise<() => void>}
 */
export async function showAccount(main) {
  document.title = "Account · Mercury";
  const session = await get("/session");
  if (!session.user) {
    put(main, el("h1", {}, "Account"), el("p", { class: "quiet" }, "A link to a run has no account."));
    return () => {};
  }
  const list = el("div");
  put(main, el("h1", {}, `Account of ${session.user}`), el("div", { class: "row" },
    el("button", { onclick: () => out("/session") }, "Log out"),
    !session.read_only && el("button", { onclick: () => out("/sessions") }, "Log out everywhere")), list);

  /** @param {string} path */
  async function out(path) {
    await remove(path).catch((error) => toast(error instanceof Error ? error.message : String(error), true));
    location.href = "/";
  }

  /** @param {() => Promise<any>} what */
  async function act(what) {
    await what().catch((error) => toast(error instanceof Error ? error.message : String(error), true));
    await load();
  }

  /** @param {string} path @param {string} word @param {string} question */
  const taken = (path, word, question) => !session.read_only && el("button", { onclick: async () => {
    if (await ask(`${word}?`, question, word) !== null) await act(() => remove(path));
  } }, word);

  /** @param {string} title @param {string} text @param {any[][]} rows @param {any} [more] */
  const card = (title, text, rows, more) => el("div", { class: "card" }, el("h2", {}, title), el("p", { class: "quiet small" }, text), more,
    rows.length > 0 && el("table", {}, el("tbody", {}, rows.map((row) => el("tr", {}, row.map((cell) => el("td", {}, cell)))))));

  const name = el("input", { required: true, maxlength: "200", placeholder: "Purpose", "aria-label": "Purpose of a new token", class: "grow" });
  const fresh = el("p", { role: "status" });
  const make = el("form", { class: "row", onsubmit: async (/** @type {Event} */ event) => {
    event.preventDefault();
    await act(async () => {
      const made = await post("/tokens", { name: name.value });
      put(fresh, "Copy the token now; it is not shown again: ", el("code", {}, made.secret));
      name.value = "";
    });
  } }, name, el("button", {}, "New token"));

  const url = el("input", { type: "url", required: true, maxlength: "2000", placeholder: "https://example.org/path", "aria-label": "URL of the web hook", class: "grow" });
  const key = el("p", { role: "status" });
  const hooked = el("form", { class: "row", onsubmit: async (/** @type {Event} */ event) => {
    event.preventDefault();
    await act(async () => {
      const made = await (await send("/hook", { url: url.value })).json();
      put(key, "Copy the secret of the signatures now; it is not shown again: ", el("code", {}, made.secret));
    });
  } }, url, el("button", {}, "Save"));

  /** @param {any} one a delivery */
  const outcome = (one) => one.message ? `${one.next ? "sent again soon" : "not delivered"}: ${one.message}` : one.next ? "waits" : "delivered";

  async function load() {
    const [sessions, tokens, shares, inputs, hook, users] = await Promise.all([get("/sessions"), get("/tokens"), get("/shares"), get("/inputs"), get("/hook"), session.admin ? get("/users") : []]);
    url.value ||= hook.url ?? "";
    put(list,
      card("Sessions", "Browsers that are logged in. A session ends with the token or the password that began it.",
        sessions.map((/** @type {any} */ one) => [one.current ? "this browser" : one.token ? `by token ${one.token}` : "by password or link", `begun ${ago(one.created)}`, `ends ${day(one.expires)}`,
          taken(`/sessions/${one.id}`, "End", "The browser with this session is logged out.")])),
      card("Tokens", "Programs log in with a token. What it has begun ends with it.",
        tokens.map((/** @type {any} */ one) => [one.name, one.read_only ? "looks only" : "may change", `ends ${day(one.expires)}`,
          taken(`/tokens/${one.id}`, "Take back", `Programs with the token “${one.name}” are logged out.`)]), !session.read_only && el("div", {}, make, fresh)),
      card("Links to runs", "Anyone with such a link looks at the run until the link ends.",
        shares.map((/** @type {any} */ one) => [el("a", { href: `/runs/${one.run}` }, one.run.slice(0, 8)), `ends ${day(one.expires)}`,
          taken(`/shares/${one.id}`, "Take back", "Holders of this link do not see the run any more.")])),
      card("Web hook", hook.url ? `Each end of a run of yours is sent to ${hook.url}.` : "Each end of a run of yours can be sent to a URL: a chat, or a program of yours.",
        hook.deliveries.slice(0, 20).map((/** @type {any} */ one) => [one.run ? el("a", { href: `/runs/${one.run}` }, one.run.slice(0, 8)) : "test", one.state, ago(one.created), outcome(one)]),
        !session.read_only && el("div", {}, hooked, hook.url && el("p", { class: "row" },
          el("button", { onclick: () => act(() => post("/hook/test", {})) }, "Send a test"),
          el("button", { onclick: load }, "Look again"),
          el("button", { onclick: async () => {
            if (await ask("Remove?", "Ends of runs are not sent any more, and the list of messages is removed.", "Remove") !== null) await act(async () => { await remove("/hook"); put(key); url.value = ""; });
          } }, "Remove")), key)),
      card("Inputs that no run names", "Files that were sent for a scene. Others go with the last run that names them.",
        inputs.filter((/** @type {any} */ one) => one.runs === 0).map((/** @type {any} */ one) => [el("code", {}, one.sha256.slice(0, 12)), size(one.bytes),
          taken(`/inputs/${one.sha256}`, "Delete", "Scenes that name this file have to send it again.")])),
      session.admin && card("Users", "`mercury-cloud user NAME` adds a user, and changes password, limits and rights.",
        users.map((/** @type {any} */ one) => [one.name, one.admin ? "administrator" : "", `${size(one.usage.disk)}${one.usage.most_disk == null ? "" : ` of ${size(one.usage.most_disk)}`}`, `${duration(one.usage.core_seconds)} of a core${one.usage.most_core_seconds == null ? "" : `, ${duration(one.usage.most_core_seconds)} at most`}`,
          one.name !== session.user && one.name !== "local" && taken(`/users/${encodeURIComponent(one.name)}`, "Remove", `${one.name} is removed with all secrets, runs and inputs.`)])));
  }
  await load();
  return () => {};
}
