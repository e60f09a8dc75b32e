// The page of a run that ends when a result is known: value and error at each look, what is missing, the band over time, the time left.
// known.mjs LINK RUN: a link that logs in, and a run that computes. PICTURES=folder keeps pictures.
import { Browser, sleep } from "./browser.mjs";

const [link, run] = process.argv.slice(2);
if (!run) throw new Error("known.mjs LINK RUN");
const browser = await Browser.start();
try {
  await browser.look(1366, 768, false);
  await browser.open(link);
  await browser.until(`document.getElementById("who")?.innerText`, "not logged in");
  await browser.open(`${new URL(link).origin}/runs/${run}`);
  const card = `[...document.querySelectorAll(".card")].find((one) => one.querySelector("h2")?.innerText === "Results")`;
  for (const part of ["torque = ", " ± ", "wanted: ± ", "s of simulated time more"]) await browser.until(`${card}?.innerText.includes(${JSON.stringify(part)})`, `no ${part}`, 60);
  await browser.until(`${card}.querySelector(".chart[aria-label^='torque / N m'] canvas")`, "no band");
  await browser.until(`document.body.innerText.includes("until the results are known")`, "no forecast", 60);
  for (const [name, width, height, dark, phone] of [["light", 1366, 768, false, false], ["dark", 1366, 768, true, false], ["phone", 390, 844, false, true]]) {
    await browser.look(width, height, dark, phone);
    await browser.until(`${card}?.querySelector("canvas")`, "no band");
    await sleep(500);
    await browser.run(`${card}.scrollIntoView({ block: "center" })`);
    await sleep(300);
    await browser.picture(`known-${name}.png`);
    if (await browser.run(`document.documentElement.scrollWidth > innerWidth`)) throw new Error(`the page is wider than ${width}`);
  }
  if (browser.complaints.length) throw new Error(`the console complains:\n${browser.complaints.join("\n")}`);
  console.log(await browser.run(`${card}.querySelector(".result").innerText.replaceAll("\\n", "; ")`));
} finally {
  await browser.stop();
}
