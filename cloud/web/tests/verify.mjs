// The page of a finished run: what differed is there, Verify shows share and link. verify.mjs LINK RUN; PICTURES=folder keeps pictures.
import { Browser } from "./browser.mjs";

const [link, run] = process.argv.slice(2);
if (!run) throw new Error("verify.mjs LINK RUN");
const browser = await Browser.start();
try {
  await browser.look(1366, 768, false);
  await browser.open(link);
  await browser.until(`document.getElementById("who")?.innerText`, "not logged in");
  await browser.open(`${new URL(link).origin}/runs/${run}`);
  await browser.until(`document.body.innerText.includes("Differs: drum.ene")`, "the difference is not shown");
  await browser.click("Verify");
  await browser.until(`/Verified: [0-9.]+ % of the steps made again; last link [0-9a-f]{12}/.test(document.body.innerText)`, "not verified", 180);
  for (const [name, width, height, dark, phone] of [["light", 1366, 768, false, false], ["dark", 1366, 768, true, false], ["phone", 390, 844, false, true]]) {
    await browser.look(width, height, dark, phone);
    await browser.picture(`verify-${name}.png`);
    if (await browser.run(`document.documentElement.scrollWidth > innerWidth`)) throw new Error(`the page is wider than ${width}`);
  }
  if (browser.complaints.length) throw new Error(`the console complains:\n${browser.complaints.join("\n")}`);
  console.log("differs, verified");
} finally {
  await browser.stop();
}
