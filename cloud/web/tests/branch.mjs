// The page of a finished run: Branch here submits a run at the time of the slider. branch.mjs LINK RUN; PICTURES=folder keeps pictures.
import { Browser } from "./browser.mjs";

const [link, run] = process.argv.slice(2);
if (!run) throw new Error("branch.mjs LINK RUN");
const browser = await Browser.start();
try {
  await browser.look(1366, 768, false);
  await browser.open(link);
  await browser.until(`document.getElementById("who")?.innerText`, "not logged in");
  await browser.open(`${new URL(link).origin}/runs/${run}`);
  const slider = `document.querySelector("[aria-label=Frame]")`;
  await browser.until(`Number(${slider}?.max) > 60`, "no frames");
  await browser.run(`${slider}.value = 50; ${slider}.dispatchEvent(new Event("input"))`);
  await browser.until(`document.body.innerText.includes("51 of ")`, "another frame");
  await browser.picture("branch-page.png");
  await browser.click("Branch here");
  await browser.until(`document.querySelector("dialog[open] textarea")`, "no field for changes");
  await browser.run(`document.querySelector("dialog textarea").value = "gravity = [0, 0, -5]"`);
  await browser.picture("branch-dialog.png");
  await browser.run(`document.querySelector("dialog button.main").click()`);
  await browser.until(`location.pathname.startsWith("/runs/") && !location.pathname.includes("${run}")`, "no new run");
  await browser.until(`document.body.innerText.includes("came to its end") || document.body.innerText.toLowerCase().includes("finished")`, "the branch does not end", 120);
  if (browser.complaints.length) throw new Error(`the console complains:\n${browser.complaints.join("\n")}`);
  console.log("a branch from the page");
} finally {
  await browser.stop();
}
