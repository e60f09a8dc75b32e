// The film of the README: a scene from the template, submitted, particles and chart as they come. Pictures go into PICTURES, as
// film-000.png and so on; ffmpeg makes a film of them (docs/how-to/cloud-laptop.md says how). film.mjs LINK
import { Browser, sleep } from "./browser.mjs";

const link = process.argv[2] ?? process.env.MERCURY_CLOUD_LINK;
if (!link || !process.env.PICTURES) throw new Error("PICTURES=folder film.mjs LINK");
const browser = await Browser.start();
let taken = 0;
/** Takes so many pictures. */
async function film(pictures, wait = 0) {
  for (let k = 0; k < pictures; k += 1) {
    await browser.picture(`film-${String(taken++).padStart(3, "0")}.png`);
    if (wait) await sleep(wait);
  }
}

try {
  await browser.look(1120, 860, false);
  await browser.open(link);
  await browser.until(`document.getElementById("who")?.innerText`, "not logged in");
  await browser.click("New run");
  await browser.until(`document.body.innerText.includes("can run") && Number(document.querySelector(".viewer canvas")?.dataset.frames ?? 0) > 0`, "not checked");
  await browser.run(`(() => { const area = document.querySelector("[aria-label=Scene]"); area.value = area.value.replace(/end +=.*/, "end  = ${process.env.FILM_END ?? "1.6"}").replace(/interval *= *[0-9.]+/, "interval = 0.02"); area.dispatchEvent(new Event("input")); })()`);
  await sleep(1500);
  await browser.until(`document.body.innerText.includes("can run")`, "not checked");
  await film(4);
  // A mistake, marked at its line.
  await browser.run(`(() => { const area = document.querySelector("[aria-label=Scene]"); window.before = area.value; area.value = area.value.replace("restitution = 0.5", "restitutoin = 0.5"); area.dispatchEvent(new Event("input")); })()`);
  await browser.until(`document.querySelectorAll(".problems li").length > 0`, "no mistake");
  await film(5);
  await browser.run(`(() => { const area = document.querySelector("[aria-label=Scene]"); area.value = window.before; area.dispatchEvent(new Event("input")); })()`);
  await browser.until(`document.querySelectorAll(".problems li").length === 0 && document.body.innerText.includes("can run")`, "still a mistake");
  await film(2);
  await browser.click("Submit");
  await browser.until(`document.querySelector(".said")?.innerText.match(/[1-9][0-9]* particles/) && document.querySelector(".chart canvas")`, "no particles");
  const max = `Number(document.querySelector("input[aria-label=Frame]")?.max ?? 0)`;
  let seen = -1;
  // A picture for each state that the page shows, until the run has finished.
  for (let k = 0; k < 400; k += 1) {
    const now = await browser.run(max);
    if (now !== seen) { seen = now; await film(1); }
    if (await browser.run(`!!document.querySelector(".state.finished")`)) break;
    await sleep(200);
  }
  await sleep(3000);
  await film(2);
  // Played again from the beginning.
  const last = await browser.run(max);
  for (let frame = 0; frame <= last; frame += 2) {
    await browser.run(`(() => { const slider = document.querySelector("input[aria-label=Frame]"); slider.value = ${frame}; slider.dispatchEvent(new Event("input")); })()`);
    await sleep(450);
    await film(1);
  }
  // Turned by hand, and played again.
  const box = await browser.run(`(() => { const box = document.querySelector(".viewer canvas").getBoundingClientRect(); return [box.x + box.width / 2, box.y + box.height / 2]; })()`);
  const mouse = (type, x) => browser.send("Input.dispatchMouseEvent", { type, x, y: box[1], button: "left", buttons: 1, clickCount: 1 });
  await mouse("mousePressed", box[0]);
  for (let k = 1; k <= 10; k += 1) { await mouse("mouseMoved", box[0] + 12 * k); await sleep(350); await film(1); }
  await mouse("mouseReleased", box[0] + 120);
  await sleep(600);
  await film(4);
  console.log(`${taken} pictures`);
} finally {
  await browser.stop();
}
