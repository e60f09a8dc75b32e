// Unknown addresses, a server that is away, a session that is over, buttons while a run runs, values of charts, a scene that is dropped.
// states.mjs LINK RUN: a link that logs in, and a run that runs.
import { Browser, sleep } from "./browser.mjs";

const [link, run] = process.argv.slice(2);
if (!run) throw new Error("states.mjs LINK RUN");
const origin = new URL(link).origin;
const browser = await Browser.start();

function must(condition, text) {
  if (!condition) throw new Error(text);
}

const banner = `(document.getElementById("banner").hidden ? "" : document.getElementById("banner").innerText)`;

try {
  await browser.look(1366, 768, false);
  await browser.open(link);
  await browser.until(`document.getElementById("who")?.innerText`, "not logged in");
  await browser.open(`${origin}/no/such/page`);
  await browser.until(`document.body.innerText.includes("No such page")`, "an unknown address shows another page", 10);

  // A button that has the focus keeps it while the run goes on.
  await browser.open(`${origin}/runs/${run}`);
  await browser.until(`[...document.querySelectorAll("button")].some((button) => button.innerText === "Stop")`, "no button", 20);
  await browser.run(`(() => { window.pressed = [...document.querySelectorAll("button")].find((button) => button.innerText === "Stop"); window.pressed.focus(); })()`);
  const step = `document.querySelector("dl.facts dd").innerText`;
  const before = await browser.run(step);
  await browser.until(`${step} !== ${JSON.stringify(before)}`, "the run does not go on", 30);
  must(await browser.run(`document.activeElement === window.pressed && window.pressed.isConnected`), "a button is made anew while it has the focus");

  // The legend of a chart has the value at the pointer, with its unit.
  await browser.until(`document.querySelectorAll(".chart .u-over").length > 0`, "no chart", 40);
  await browser.run(`document.querySelector(".chart .u-over").scrollIntoView({ block: "center" })`);
  const place = await browser.run(`(() => { const { x, y, width, height } = document.querySelector(".chart .u-over").getBoundingClientRect(); return [x + width / 2, y + height / 2]; })()`);
  await browser.send("Input.dispatchMouseEvent", { type: "mouseMoved", x: place[0], y: place[1] });
  const values = `[...document.querySelectorAll(".chart .u-legend .u-value")].map((value) => value.innerText)`;
  await browser.until(`${values}.some((value) => / J$/.test(value) && parseFloat(value) !== 0)`, "no value at the pointer", 15);
  await browser.picture("states.png");

  // A server that is away, and comes back.
  await browser.send("Network.emulateNetworkConditions", { offline: true, latency: 0, downloadThroughput: -1, uploadThroughput: -1 });
  await browser.run(`document.getElementById("tab-Attempts").click()`);
  await browser.until(`${banner}.includes("does not respond")`, "no banner while the server is away", 20);
  await browser.send("Network.emulateNetworkConditions", { offline: false, latency: 0, downloadThroughput: -1, uploadThroughput: -1 });
  await browser.run(`document.getElementById("tab-Log").click()`);
  await browser.until(`${banner} === ""`, "the banner stays", 30);
  browser.complaints.length = 0;

  // A scene that is dropped, with a file.
  await browser.open(`${origin}/new`);
  const scene = `document.querySelector("textarea[aria-label=Scene]")`;
  await browser.until(`${scene}?.value.includes("drum")`, "no template", 20);
  await browser.run(`(() => {
    const data = new DataTransfer();
    data.items.add(new File(["x,y\\n"], "points.csv"));
    data.items.add(new File([${scene}.value + "\\n# dropped"], "mine.toml"));
    document.querySelector(".drop").dispatchEvent(new DragEvent("drop", { dataTransfer: data, bubbles: true, cancelable: true }));
  })()`);
  await browser.until(`${scene}.value.endsWith("# dropped") && document.querySelector(".chips").innerText.includes("points.csv")`, "a scene cannot be dropped", 15);
  await browser.run(`localStorage.clear()`);
  must(browser.complaints.length === 0, browser.complaints.join("\n"));

  // A session that is over.
  await browser.open(`${origin}/runs/${run}`);
  await browser.until(`document.getElementById("who").innerText.includes("local")`, "not logged in", 10);
  await browser.run(`fetch("/api/v1/sessions", { method: "DELETE" })`);
  await browser.run(`document.getElementById("tab-Files").click()`);
  await browser.until(`${banner}.includes("session is over")`, "no banner when the session is over", 20);
  await sleep(100);
} finally {
  await browser.stop();
}
