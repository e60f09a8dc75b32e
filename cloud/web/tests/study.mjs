// A study from the page: a grid in a form, a study file, the table, the plot, charts over each other, two runs side by side.
// study.mjs LINK; PICTURES=folder keeps pictures.
import { Browser, sleep } from "./browser.mjs";

const link = process.argv[2] ?? process.env.MERCURY_CLOUD_LINK;
if (!link) throw new Error("study.mjs LINK: the link that `mercury-cloud serve` prints");
const end = process.env.STUDY_END ?? "0.1";
const browser = await Browser.start();
const began = Date.now();
const said = (text) => console.log(`${((Date.now() - began) / 1000).toFixed(1)} s  ${text}`);

// The form of a study: there are other details on the page.
const form = `document.querySelector("[aria-label='Keys and their values']").closest("details")`;

/** Types into a field. */
const type = (label, text) => browser.run(`(() => { const field = document.querySelector(${JSON.stringify(`[aria-label="${label}"]`)}); field.value = ${text}; field.dispatchEvent(new Event("input")); })()`);

try {
  await browser.look(1280, 1000, false);
  await browser.open(link);
  await browser.until(`document.getElementById("who")?.innerText`, "not logged in");
  await browser.click("New run");
  await browser.until(`document.body.innerText.includes("can run")`, "not checked");
  await browser.run(`window.before = document.querySelector("[aria-label=Scene]").value`);
  await type("Scene", `window.before.replace(/end +=.*/, "end  = ${end}").replace(/interval *= *[0-9.]+/, "interval = 0.01")`);
  await browser.run(`${form}.querySelector("summary").click()`);
  await type("Keys and their values", `"walls.drum.motion.0.angular_velocity = 1, nothing"`);
  await browser.until(`${form}.querySelector(".bad-text")`, "the mistake in the grid is not reported", 15);
  said(`a mistake is reported: ${await browser.run(`${form}.querySelector(".bad-text").innerText.slice(0, 100)`)}`);
  await type("Keys and their values", `"materials.0.tangential.friction = 0.1..0.5/3\\nseed = 1, 2"`);
  await type("Results", `"height = max(particles.z)"`);
  await browser.until(`document.body.innerText.includes("Submit 6 runs")`, "the grid has no six runs", 15);
  await browser.run(`${form}.scrollIntoView({ block: "center" })`);
  await browser.picture("study-new.png");
  // This grid as a file, and back.
  await browser.click("From a file instead");
  await browser.until(`document.querySelector("[aria-label='Study file']").value.includes("[study.sweep]") && document.body.innerText.includes("Submit 6 runs")`, "the study file is not the same study", 15);
  await browser.picture("study-file.png");
  await browser.click("Submit 6 runs");
  await browser.until(`location.pathname.startsWith("/studies/")`, "not submitted");
  said("submitted");
  await browser.until(`document.querySelectorAll("table.study tbody tr").length === 6`, "no six rows");
  await browser.until(`document.querySelectorAll(".state.finished").length === 6`, "not all finished", 300);
  await browser.until(`[...document.querySelectorAll("table.study tbody tr")].every((row) => row.lastElementChild.innerText.trim() !== "")`, "no results", 20);
  await browser.until(`document.querySelector(".chart[aria-label^=height] canvas")`, "no plot");
  said("all finished; the plot is there");
  await browser.open(`${new URL(link).origin}${await browser.run("location.pathname")}`);
  await browser.until(`document.querySelectorAll(".chart canvas").length >= 2`, "no charts over each other");
  // Two seeds of three frictions: means with errors, and differences from the first.
  await browser.until(`document.querySelectorAll("table.means tbody tr").length === 3`, "no means");
  const means = await browser.run(`[...document.querySelectorAll("table.means tbody tr")].map((row) => [...row.children].map((cell) => cell.innerText))`);
  if (!means.every((row) => row[1] === "2" && row[2].includes("±")) || !means[1][3].includes("±") || means[0][3] !== "") throw new Error(`means: ${JSON.stringify(means)}`);
  await sleep(500);
  await browser.picture("study.png");
  for (const [name, width, height, dark, phone] of [["light", 1366, 768, false, false], ["dark", 1366, 768, true, false], ["phone", 390, 844, false, true]]) {
    await browser.look(width, height, dark, phone);
    await browser.until(`document.querySelectorAll("table.means tbody tr").length === 3`, "no means");
    await browser.run(`document.querySelector("table.means").scrollIntoView({ block: "center" })`);
    await sleep(500);
    await browser.picture(`study-means-${name}.png`);
    if (await browser.run(`document.documentElement.scrollWidth > innerWidth`)) throw new Error(`the page is wider than ${width}`);
  }
  await browser.look(1280, 1000, false);
  await sleep(1000);
  await browser.click("height / m");
  await browser.until(`(() => { const column = [...document.querySelectorAll("table.study tbody tr")].map((row) => Number(row.lastElementChild.innerText)); return column.every((value, k) => k === 0 || column[k - 1] <= value); })()`, "not sorted");
  for (const row of [0, 5]) await browser.run(`document.querySelectorAll("table.study tbody input")[${row}].click()`);
  await browser.click("Compare");
  await browser.until(`document.querySelectorAll(".viewer canvas").length >= 2 && document.querySelector(".chart canvas")`, "no comparison");
  await sleep(2500);
  await browser.picture("compare.png");
  await browser.run(`scrollTo(0, document.body.scrollHeight)`);
  await sleep(500);
  await browser.picture("compare-3d.png");
  await browser.click("Studies");
  await browser.until(`document.querySelectorAll("tbody tr").length >= 1`, "no list of studies");
  await browser.picture("studies.png");
  if (browser.complaints.length) throw new Error(`the console complains:\n${browser.complaints.join("\n")}`);
  said("no complaint");
} finally {
  await browser.stop();
}
