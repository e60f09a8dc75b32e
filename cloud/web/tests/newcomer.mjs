// A newcomer: opens the link, takes the drum, submits, sees particles move, the chart grow and the log, stops, resumes,
// downloads. No complaint in the console. newcomer.mjs LINK; PICTURES=folder keeps pictures.
import { Browser, sleep } from "./browser.mjs";

const link = process.argv[2] ?? process.env.MERCURY_CLOUD_LINK;
if (!link) throw new Error("newcomer.mjs LINK: the link that `mercury-cloud serve` prints");
// Frames come with each commit, every 5 s: a run of some 20 s still goes on when further ones were seen.
const end = process.env.NEWCOMER_END ?? "3.0";
const browser = await Browser.start();
const began = Date.now();
const said = (text) => console.log(`${((Date.now() - began) / 1000).toFixed(1)} s  ${text}`);

function must(condition, text) {
  if (!condition) throw new Error(text);
}

try {
  await browser.look(1280, 900, false);
  await browser.open(link);
  await browser.until(`document.getElementById("who")?.innerText`, "not logged in");
  await browser.click("New run");
  await browser.until(`document.querySelector("textarea")?.value.includes("drum")`, "no template");
  await browser.until(`document.body.innerText.includes("can run")`, "not checked");
  said("the drum is there, and can run");
  await browser.until(`Number(document.querySelector(".viewer canvas")?.dataset.frames ?? 0) > 0`, "no preview");
  await browser.picture("new.png");

  // A mistake is marked at its line within half a second.
  const typed = (text) => browser.run(`(() => { const area = document.querySelector("textarea"); area.value = ${text}; area.dispatchEvent(new Event("input")); })()`);
  await browser.run(`window.before = document.querySelector("textarea").value`);
  await typed(`window.before.replace("density    = 2500.0", "density    = -1.0").replace("restitution = 0.5", "restitutoin = 0.5")`);
  const mistake = Date.now();
  await browser.until(`document.querySelectorAll(".problems li").length >= 1`, "the mistake is not found", 5);
  said(`the mistake is marked after ${Date.now() - mistake} ms`);
  await browser.picture("problem.png");
  await typed(`window.before.replace(/end +=.*/, "end  = ${end}").replace(/interval *= *[0-9.]+/, "interval = 0.03")`);
  await browser.until(`document.querySelectorAll(".problems li").length === 0 && document.body.innerText.includes("can run")`, "still a mistake", 10);

  await browser.click("Submit");
  await browser.until(`location.pathname.startsWith("/runs/")`, "not submitted");
  const run = (await browser.run("location.pathname")).slice(6);
  said(`submitted: ${run}`);
  await browser.until(`document.querySelector(".state.running")`, "does not run");
  // Frames come, and the picture changes.
  const frames = `Number(document.querySelector(".viewer canvas")?.dataset.frames ?? 0)`;
  await browser.until(`document.querySelector(".said")?.innerText.match(/[1-9][0-9]* particles/)`, "no particles");
  const first = await browser.run(`document.querySelector("input[aria-label=Frame]").max`);
  await browser.until(`Number(document.querySelector("input[aria-label=Frame]").max) > ${first}`, "no further frame");
  must(await browser.run(frames) > 1, "nothing was drawn");
  said("particles move");
  await browser.until(`document.querySelector(".chart canvas")`, "no chart");
  await browser.picture("running.png");

  await browser.click("Stop");
  await browser.until(`document.querySelector(".state.stopped, .state.finished")`, "does not stop");
  said("stopped");
  await browser.picture("stopped.png");
  if (await browser.run(`!!document.querySelector(".state.stopped")`)) {
    await browser.click("Resume");
    await browser.until(`document.querySelector(".state.running, .state.finished")`, "does not resume");
    said("resumed");
  }
  await browser.click("Log");
  await browser.until(`document.querySelector("[aria-label=Log]")?.innerText.length > 100`, "no log");
  await browser.picture("log.png");
  await browser.click("Overview");
  await browser.until(`document.querySelector(".state.finished")`, "does not finish", 300);
  said("finished");
  await sleep(2500);
  await browser.picture("finished.png");
  await browser.click("Charts");
  await browser.until(`document.querySelector("#pane-Charts .chart canvas")`, "no chart of a column");
  await browser.picture("charts.png");
  await browser.click("Attempts");
  await browser.until(`document.querySelectorAll("#pane-Attempts tbody tr").length >= 1`, "no attempts");
  await browser.picture("attempts.png");
  await browser.click("Files");
  await browser.until(`document.querySelectorAll("#pane-Files tbody a").length > 5`, "no files");
  const zip = await browser.run(`fetch("/api/v1/runs/${run}/archive").then((a) => a.arrayBuffer()).then((b) => [b.byteLength, ...new Uint8Array(b, 0, 2)])`);
  must(zip[0] > 10000 && zip[1] === 0x50 && zip[2] === 0x4b, `no archive: ${zip}`);
  said(`downloaded ${zip[0]} bytes`);
  await browser.picture("files.png");
  await browser.click("Projects");
  await browser.until(`document.querySelector("[aria-label='Name of a new project']")`, "no page of projects");
  await browser.run(`document.querySelector("[aria-label='Name of a new project']").value = "Drums"`);
  await browser.click("New project");
  await browser.until(`document.body.innerText.includes("0 runs")`, "no project");
  await browser.open(`${new URL(link).origin}/runs/${run}`);
  await browser.until(`document.querySelector("select[aria-label=Project]")`, "no choice of a project");
  await browser.run(`(() => { const choice = document.querySelector("select[aria-label=Project]"); choice.selectedIndex = 1; choice.dispatchEvent(new Event("change")); })()`);
  await browser.click("Projects");
  await browser.until(`document.body.innerText.includes("1 run")`, "the run is not in the project");
  await browser.picture("projects.png");
  await browser.click("1 run");
  await browser.until(`document.querySelectorAll("tbody tr").length === 1`, "the project lists no run");
  await browser.picture("project-runs.png");
  said("the run is in a project");
  await browser.open(`${new URL(link).origin}/runs/${run}`);
  await browser.until(`document.querySelector(".chart canvas")`, "no chart");
  await sleep(2500);
  await browser.look(390, 844, false, true);
  await browser.picture("phone.png");
  await browser.look(1280, 900, true);
  await sleep(800);
  await browser.picture("dark.png");
  await browser.click("Runs");
  await browser.until(`document.querySelectorAll("tbody tr").length >= 1`, "no list");
  await browser.picture("list-dark.png");
  await browser.look(390, 844, true, true);
  await browser.picture("list-phone-dark.png");
  await browser.look(390, 844, false, true);
  await browser.open(`${new URL(link).origin}/new`);
  await browser.until(`document.body.innerText.includes("can run")`, "not checked");
  await browser.picture("new-phone.png");
  must(browser.complaints.length === 0, `the console complains:\n${browser.complaints.join("\n")}`);
  said("no complaint");
} finally {
  await browser.stop();
}
