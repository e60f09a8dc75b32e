// A run on two ranks from the form, where the server offers them; its page says so. ranks.mjs LINK; PICTURES=folder keeps pictures.
import { Browser } from "./browser.mjs";

const link = process.argv[2];
if (!link) throw new Error("ranks.mjs LINK: a link that logs in");
const browser = await Browser.start();
const ranks = `[...document.querySelectorAll("label")].find((label) => label.innerText.trim() === "Ranks")?.querySelector("input")`;
const settings = `document.querySelector("textarea[aria-label^=Settings]")`;

try {
  await browser.look(1366, 768, false);
  await browser.open(link);
  await browser.until(`document.getElementById("who")?.innerText`, "not logged in");
  await browser.click("New run");
  await browser.until(`document.body.innerText.includes("can run")`, "not checked");
  await browser.run(`(() => { const area = ${settings}; area.value = "time.end = 0.001"; area.dispatchEvent(new Event("input")); })()`);
  await browser.until(`Number(${ranks}?.max) === 2`, "ranks are not offered");
  await browser.run(`(() => { const field = ${ranks}; field.value = "2"; field.dispatchEvent(new Event("input")); })()`);
  await browser.picture("ranks-form.png");
  await browser.click("Submit");
  await browser.until(`location.pathname.startsWith("/runs/")`, "not submitted");
  await browser.until(`document.body.innerText.includes("came to its end") || document.body.innerText.toLowerCase().includes("finished")`, "the run does not end", 120);
  await browser.until(`[...document.querySelectorAll("dt")].some((term) => term.innerText === "Ranks" && term.nextElementSibling.innerText === "2")`, "the page does not show the ranks");
  await browser.picture("ranks-run.png");
  if (browser.complaints.length) throw new Error(`the console complains:\n${browser.complaints.join("\n")}`);
  console.log("a run on two ranks from the page");
} finally {
  await browser.stop();
}
