// The draft of a new run survives reload, dark and another template, and a lost answer makes no second run; the account is listed, and a
// link asks before it replaces a session. draft.mjs LINK; PICTURES=folder keeps pictures.
import { Browser } from "./browser.mjs";

const link = process.argv[2] ?? process.env.MERCURY_CLOUD_LINK;
if (!link) throw new Error("draft.mjs LINK: a link that logs in");
const browser = await Browser.start();

function must(condition, text) {
  if (!condition) throw new Error(text);
}

const scene = `document.querySelector("textarea[aria-label=Scene]")`;
const settings = `document.querySelector("textarea[aria-label^=Settings]")`;
const fill = (area, text) => browser.run(`(() => { const area = ${area}; area.value = ${text}; area.dispatchEvent(new Event("input")); })()`);
const kept = (what) => browser.until(`${scene}?.value.endsWith("# mine") && ${settings}.value.includes("0.001")`, `the draft is lost ${what}`, 15);

try {
  await browser.look(1280, 900, false);
  await browser.open(link);
  await browser.until(`document.getElementById("who")?.innerText`, "not logged in");
  await browser.click("New run");
  await browser.until(`${scene}?.value.includes("drum")`, "no template");
  await fill(scene, `${scene}.value + "\\n# mine"`);
  await fill(settings, `"time.end = 0.001\\noutput.pictures = false"`);
  await browser.send("Page.reload");
  await kept("by a reload");
  await browser.look(1280, 900, true);
  await kept("by dark");
  await browser.look(1366, 768, false);
  await kept("by light");
  await browser.picture("draft.png");
  await browser.click("Hopper");
  await browser.until(`document.querySelector("dialog")?.innerText.includes("Replace the scene?")`, "a template does not ask", 10);
  await browser.click("Cancel");
  await kept("by a template");

  // The run is made, and its answer is lost: the same draft sent again is the same run.
  await browser.until(`document.body.innerText.includes("can run")`, "not checked");
  await browser.run(`(() => { const real = window.fetch; window.fetch = async (path, more) => {
    const answer = await real(path, more);
    if (path.endsWith("/runs") && more?.method === "POST") { window.fetch = real; throw new TypeError("lost"); }
    return answer;
  }; })()`);
  await browser.click("Submit");
  await browser.until(`document.getElementById("toasts").innerText.includes("does not respond")`, "the answer is not lost", 20);
  await browser.send("Page.reload");
  await kept("by a lost answer");
  await browser.until(`document.body.innerText.includes("can run")`, "not checked");
  await browser.click("Submit");
  await browser.until(`location.pathname.startsWith("/runs/")`, "not submitted");
  const runs = await browser.run(`fetch("/api/v1/runs").then((answer) => answer.json()).then((list) => list.runs.length)`);
  must(runs === 1, `${runs} runs`);
  const origin = new URL(link).origin;
  await browser.open(`${origin}/new`);
  await browser.until(`${scene}?.value.includes("drum") && !${scene}.value.includes("# mine")`, "the draft outlives its run", 15);

  await browser.open(`${origin}/account`);
  await browser.until(`document.body.innerText.includes("Log out everywhere") && document.body.innerText.includes("this browser") || document.body.innerText.includes("by token")`, "no account", 15);
  await browser.picture("account.png");
  await browser.open("about:blank");
  await browser.open(`${origin}/#token=0`);
  await browser.until(`document.querySelector("dialog")?.innerText.includes("Log in by this link?")`, "a link does not ask", 15);
  await browser.click("Cancel");
  await browser.until(`document.getElementById("who").innerText.includes("local")`, "the session is lost", 10);
  must(browser.complaints.length === 0, browser.complaints.join("\n"));
} finally {
  await browser.stop();
}
