// Every page by axe-core (accessibility), and by keyboard alone. axe.mjs LINK AXE.js, the latter from npm (axe-core/axe.min.js).
import { readFileSync } from "node:fs";
import { Browser, sleep } from "./browser.mjs";

const [link, axe] = process.argv.slice(2);
if (!axe) throw new Error("axe.mjs LINK AXE.js: the link that `mercury-cloud serve` prints, and axe-core's file");
const script = readFileSync(axe, "utf8");
const browser = await Browser.start();

/** Presses a key, as a keyboard does. */
async function press(key, code = key, text) {
  const keys = { Enter: 13, Tab: 9, " ": 32, ArrowRight: 39 };
  for (const type of ["keyDown", "keyUp"]) await browser.send("Input.dispatchKeyEvent", { type, key, code, windowsVirtualKeyCode: keys[key] ?? 0, text: type === "keyDown" ? text : undefined });
}

async function look(name) {
  await browser.run(`${script}; true`);
  const found = await browser.run(`axe.run(document, { resultTypes: ["violations"] }).then((all) => all.violations.map((one) => one.id + ": " + one.help + " " + one.nodes.map((node) => node.target.join(" ")).slice(0, 3).join("; ")))`);
  if (found.length) throw new Error(`${name}:\n${found.join("\n")}`);
  console.log(`${name}: nothing found`);
}

/** Presses Tab until the element with this text has the focus. */
async function tabTo(text) {
  for (let k = 0; k < 80; k += 1) {
    await press("Tab");
    const at = await browser.run(`(document.activeElement?.innerText || document.activeElement?.getAttribute("aria-label") || "").trim()`);
    if (at.startsWith(text)) return;
  }
  throw new Error(`${text} is not reached by Tab`);
}

try {
  await browser.look(1280, 900, false);
  await browser.open(link);
  await browser.until(`document.getElementById("who")?.innerText`, "not logged in");
  await browser.until(`document.querySelector("h1")`, "no page");
  await look("list");
  // By keyboard alone: to a new run, and submitted.
  await tabTo("New run");
  await press("Enter", "Enter", "\r");
  await browser.until(`document.body.innerText.includes("can run")`, "not checked");
  for (const dark of [false, true]) { await browser.look(1280, 900, dark); await browser.until(`document.body.innerText.includes("can run")`, "not checked"); await look(dark ? "new run, dark" : "new run"); }
  await browser.run(`(() => { const area = document.querySelector("[aria-label=Scene]"); area.value = area.value.replace(/end +=.*/, "end = 0.05").replace(/interval *= *[0-9.]+/, "interval = 0.01"); area.dispatchEvent(new Event("input")); })()`);
  await sleep(1000);
  await browser.until(`document.body.innerText.includes("can run")`, "not checked");
  await tabTo("Submit");
  await press("Enter", "Enter", "\r");
  await browser.until(`location.pathname.startsWith("/runs/")`, "not submitted by keyboard");
  await browser.until(`document.querySelector(".state.finished")`, "not finished", 120);
  await sleep(1500);
  await tabTo("Overview");
  await look("run");
  for (const part of ["Charts", "Log", "Attempts", "Files", "Scene"]) {
    await press("ArrowRight");
    await browser.until(`document.activeElement?.innerText === ${JSON.stringify(part)}`, `${part} is not reached by arrows`, 5);
    await sleep(700);
    await look(`run, ${part}`);
  }
  const origin = new URL(link).origin;
  await browser.open(`${origin}/studies`);
  await sleep(700);
  await look("studies");
  await browser.open(`${origin}/account`);
  await browser.until(`document.body.innerText.includes("Web hook")`, "no account");
  await look("account");
  await browser.open(`${origin}/studies`);
  await sleep(700);
  const study = await browser.run(`document.querySelector("tbody a")?.getAttribute("href")`);
  if (study) { await browser.open(origin + study); await sleep(2500); await look("study"); }
  await browser.look(390, 844, false, true);
  await browser.open(origin);
  await sleep(1000);
  await look("list on a phone");
} finally {
  await browser.stop();
}
