// Requests to the server, and its live events.

/** An answer that is an error, with the solver's problems where there are some. */
export class Problem extends Error {
  /** @param {{title: string, status: number, detail?: string, problems?: any[]}} body */
  constructor(body) {
    super(body.detail ? `${body.title}. ${body.detail}` : body.title);
    this.status = body.status;
    /** @type {any[]} */
    this.problems = body.problems ?? [];
  }
}

/** Tells the page how the last request went: `away` (no answer), `over` (no session), `there`. @param {string} how */
const tell = (how) => dispatchEvent(new CustomEvent("server", { detail: how }));

/**
 * @param {string} method
 * @param {string} path
 * @param {any} [body]
 * @param {RequestInit} [more]
 * @returns {Promise<Response>}
 */
async function request(method, path, body, more = {}) {
  const binary = body instanceof Blob;
  const headers = body === undefined || binary ? more.headers : { "content-type": "application/json", ...more.headers };
  let answer;
  try {
    answer = await fetch(`/api/v1${path}`, { ...more, method, headers, body: body === undefined || binary ? body : JSON.stringify(body) });
  } catch (error) {
    if (error instanceof DOMException && error.name === "AbortError") throw error;
    tell("away");
    throw new Problem({ title: "the server does not respond", status: 0 });
  }
  tell(answer.status === 401 ? "over" : "there");
  if (answer.ok) return answer;
  const found = await answer.json().catch(() => ({ title: `the server answers ${answer.status}`, status: answer.status }));
  throw new Problem(found);
}

/** @param {string} path @param {RequestInit} [more] @returns {Promise<any>} */
export const get = async (path, more) => (await request("GET", path, undefined, more)).json();
/** @param {string} path @param {any} body @param {RequestInit} [more] @returns {Promise<any>} */
export const post = async (path, body, more) => (await request("POST", path, body, more)).json();
/** @param {string} path @param {any} body */
export const put = (path, body) => request("PUT", path, body);
/** @param {string} path @param {any} body @returns {Promise<any>} */
export const patch = async (path, body) => (await request("PATCH", path, body)).json();
/** @param {string} path */
export const remove = (path) => request("DELETE", path);
/** @param {string} path @param {RequestInit} [more] */
export const bytes = async (path, more) => (await request("GET", path, undefined, more)).arrayBuffer();

/**
 * Sends a file by its content.
 * @param {File} file
 * @returns {Promise<string>} its SHA-256
 */
export async function upload(file) {
  const digest = await crypto.subtle.digest("SHA-256", await file.arrayBuffer());
  const digits = Array.from(new Uint8Array(digest), (byte) => byte.toString(16).padStart(2, "0")).join("");
  await request("PUT", `/inputs/${digits}`, file);
  return digits;
}

/** @typedef {{id?: number, run: string, kind: string, time: number, data: any}} News */

/**
 * One stream of events for the page. It closes while the page is hidden, and replays what was missed.
 * @param {string[]} runs none: all of one's own
 * @param {(news: News) => void} hear
 * @param {() => void} anew called when something may have been missed
 * @returns {() => void} ends it
 */
export function listen(runs, hear, anew) {
  /** @type {EventSource | null} */
  let source = null;
  let last = "";
  let opened = false;
  const open = () => {
    if (source || document.hidden) return;
    const after = last ? `&after=${last}` : "";
    source = new EventSource(`/api/v1/events?runs=${runs.join(",")}${after}`);
    source.onopen = () => { tell("there"); if (opened) anew(); opened = true; };
    source.onmessage = (event) => { if (event.lastEventId) last = event.lastEventId; hear(JSON.parse(event.data)); };
    source.addEventListener("lagged", anew);
    source.onerror = () => {
      // Says whether the server is away, or the session over.
      get("/session").catch(() => {});
      // A server that restarts is not an end: browsers stop trying after some answers, and we do not.
      if (source?.readyState === EventSource.CLOSED) { source = null; setTimeout(open, 2000); }
    };
  };
  const shown = () => {
    if (document.hidden) { source?.close(); source = null; } else open();
  };
  document.addEventListener("visibilitychange", shown);
  open();
  return () => { document.removeEventListener("visibilitychange", shown); source?.close(); source = null; last = "0"; runs = []; };
}
