// Two runs beside each other: differences of their scenes, one slider of time, one range of colours; a browser without WebGL shows a
// picture. compare.mjs LINK RUN RUN: a link that logs in, and two finished runs with pictures, whose scenes differ.
import { Browser } from "./browser.mjs";

const [link, first, second] = process.argv.slice(2);
if (!second) throw new Error("compare.mjs LINK RUN RUN");
const origin = new URL(link).origin;
const browser = await Browser.start();

function must(condition, text) {
  if (!condition) throw new Error(text);
}

try {
  await browser.look(1366, 768, false);
  await browser.open(link);
  await browser.until(`document.getElementById("who")?.innerText`, "not logged in");
  await browser.open(`${origin}/compare?runs=${first},${second}`);
  await browser.until(`document.querySelector(".diff")?.innerText.includes("+ # another line")`, "the difference is not shown", 30);
  const times = `[...document.querySelectorAll(".controls span")].map((time) => time.textContent.split(" s")[0])`;
  await browser.until(`${times}.length === 2 && ${times}.every((time) => time)`, "no frames", 60);
  const sliders = await browser.run(`[...document.querySelectorAll("input[aria-label=Frame]")].filter((slider) => slider.checkVisibility()).length`);
  must(sliders === 1, `${sliders} sliders of time`);
  const before = await browser.run(`${times}[1]`);
  await browser.run(`(() => { const slider = document.querySelector("input[aria-label=Frame]"); slider.value = "1"; slider.dispatchEvent(new Event("input")); })()`);
  await browser.until(`${times}[0] === ${times}[1] && ${times}[1] !== ${JSON.stringify(before)}`, "the other run shows another time", 30);
  await browser.picture("compare.png");
  must(browser.complaints.length === 0, browser.complaints.join("\n"));

  await browser.send("Page.addScriptToEvaluateOnNewDocument", { source: `const real = HTMLCanvasElement.prototype.getContext;
    HTMLCanvasElement.prototype.getContext = function (kind, ...more) { return kind === "webgl2" ? null : real.call(this, kind, ...more); };` });
  await browser.open(`${origin}/runs/${first}`);
  await browser.until(`document.querySelector("img.still")?.naturalWidth > 0`, "no picture without WebGL", 30);
  must(await browser.run(`document.body.innerText.includes("it has no WebGL2")`), "no word about WebGL");
  await browser.picture("still.png");
  must(browser.complaints.length === 0, browser.complaints.join("\n"));
} finally {
  await browser.stop();
}
