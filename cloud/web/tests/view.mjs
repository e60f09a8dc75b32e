// The page of a finished run and that of a new one at 1366 x 768: results with errors, several charts with logarithmic axes, Reset
// view, axes and scale bar, picture, film and full screen, previews of files; problems in view, completion of keys.
// view.mjs LINK RUN: a link that logs in, and a finished run with results. PICTURES=folder keeps pictures.
import { Browser, sleep } from "./browser.mjs";

const [link, run] = process.argv.slice(2);
if (!run) throw new Error("view.mjs LINK RUN");
const origin = new URL(link).origin;
const browser = await Browser.start();

function must(condition, text) {
  if (!condition) throw new Error(text);
}

const seen = (selector) => `(() => { const box = document.querySelector(${JSON.stringify(selector)})?.getBoundingClientRect(); return !!box && box.height > 0 && box.top >= 0 && box.bottom <= innerHeight; })()`;
async function press(key, code, more = {}) {
  const keys = { Tab: 9, " ": 32, ArrowDown: 40, Enter: 13, Escape: 27 };
  for (const type of ["keyDown", "keyUp"]) await browser.send("Input.dispatchKeyEvent", { type, key, code: code ?? key, windowsVirtualKeyCode: keys[key] ?? 0, ...more });
}

try {
  await browser.look(1366, 768, false);
  await browser.open(link);
  await browser.until(`document.getElementById("who")?.innerText`, "not logged in");

  // Problems of a scene are in view at once, and stay there while the text is scrolled.
  await browser.open(`${origin}/new`);
  const scene = `document.querySelector("textarea[aria-label=Scene]")`;
  await browser.until(`${scene}?.value.includes("drum")`, "no template", 20);
  await browser.run(`(() => { const area = ${scene}; area.value = area.value.replace(/end +=.*/, "ende = 1.0"); area.dispatchEvent(new Event("input")); })()`);
  await browser.until(`document.querySelectorAll(".problems li").length >= 1`, "the mistake is not found", 15);
  must(await browser.run(seen(".problems li")), "the problem is not in view");
  await browser.picture("problem.png");
  await browser.run(`document.querySelector(".editor").scrollIntoView({ block: "end" })`);
  await sleep(200);
  must(await browser.run(seen(".problems li")), "the problem is not in view beside the text");
  await browser.picture("problem-scrolled.png");

  // Completion: keys of [time], taken by Tab; help for the key at the caret.
  await browser.run(`(() => { const area = ${scene}; area.value = "[time]\\n"; area.focus(); area.setSelectionRange(7, 7); })()`);
  await browser.send("Input.insertText", { text: "e" });
  await browser.until(`[...document.querySelectorAll(".suggestions li")].some((entry) => entry.innerText.startsWith("end"))`, "no completion", 10);
  await browser.picture("completion.png");
  await press("Tab");
  must(await browser.run(`${scene}.value === "[time]\\nend" && document.querySelector(".suggestions").hidden`), `Tab does not complete: ${await browser.run(`${scene}.value`)}`);
  await browser.until(`document.querySelector(".help").innerText.includes("simulated time")`, "no help for the key", 5);
  await browser.send("Input.insertText", { text: " = 1\nstep = " });
  await press(" ", "Space", { modifiers: 2 });
  await browser.until(`document.querySelector(".suggestions").innerText.includes("auto")`, "no values", 5);
  await press("ArrowDown");
  await press("Enter");
  must(await browser.run(`${scene}.value.endsWith('step = "auto"')`), "Enter does not complete");
  await browser.run(`localStorage.clear()`);

  // Results: value, error, interval, window, and why there is none.
  await browser.open(`${origin}/runs/${run}`);
  await browser.until(`document.body.innerText.includes("Results")`, "no results", 30);
  const results = await browser.run(`[...document.querySelectorAll(".result")].map((one) => one.innerText).join("\\n")`);
  for (const part of [/torque = \(.* ± .*\)e-4 N m/, /95 %: .* to /, /independent batches/, /top = .* m\n/, /no error: it is of one state/]) must(part.test(results), `${part} is not in the results:\n${results}`);
  await browser.until(`document.querySelector(".said")?.innerText.includes("particles")`, "no particles", 30);
  await browser.picture("results.png");

  // Reset view shows all of the domain: zoom, shift and cut are those of the beginning.
  const looked = `document.querySelector(".viewer canvas").toDataURL()`;
  const [x, y] = await browser.run(`(() => { const box = document.querySelector(".viewer canvas").getBoundingClientRect(); return [box.x + box.width / 2, box.y + box.height / 2]; })()`);
  await browser.send("Input.dispatchMouseEvent", { type: "mouseWheel", x, y, deltaX: 0, deltaY: -900 });
  await browser.run(`(() => { const cut = document.querySelector("input[aria-label=Cut]"); cut.value = "300"; cut.dispatchEvent(new Event("input")); })()`);
  await sleep(400);
  const bar = `document.querySelector(".viewer").dataset.bar`;
  const near = await browser.run(bar);
  await browser.click("Reset view");
  await sleep(400);
  must(await browser.run(`document.querySelector("input[aria-label=Cut]").value === "1000"`), "the cut stays");
  must(await browser.run(bar) !== near, `the scale bar does not follow the view: ${near}`);
  await browser.picture("reset.png");
  must(await browser.run(`${looked}.length > 1000`), "nothing is drawn");

  // A picture and a film of the view, with legend and scale bar.
  await browser.run(`(() => { window.saved = []; const make = URL.createObjectURL; URL.createObjectURL = (blob) => { window.saved.push([blob.type, blob.size]); return make.call(URL, blob); }; })()`);
  await browser.click("Picture");
  await browser.until(`window.saved.some(([kind, size]) => kind === "image/png" && size > 5000)`, "no picture", 15);
  await browser.click("Film");
  await browser.until(`window.saved.some(([kind, size]) => kind === "video/webm" && size > 5000)`, "no film", 120);
  console.log(JSON.stringify(await browser.run(`window.saved`)));
  await browser.click("Full screen");
  await browser.until(`document.fullscreenElement?.querySelector("canvas") !== null && !!document.fullscreenElement`, "not the full screen", 10);
  await sleep(500);
  await browser.picture("full-screen.png");
  await browser.run(`document.exitFullscreen()`);

  // Several charts at once, with units, logarithmic axes, kept by the browser.
  await browser.click("Charts");
  await browser.until(`document.querySelectorAll("#pane-Charts .chart canvas").length === 1`, "no chart", 20);
  await browser.click("Add a chart");
  await browser.click("Add a chart");
  await browser.until(`document.querySelectorAll("#pane-Charts .chart canvas").length === 3`, "no further charts", 20);
  must(await browser.run(`document.querySelector("#pane-Charts .chart").getAttribute("aria-label").includes(" / J")`), "a chart has no unit");
  await browser.run(`document.querySelectorAll("#pane-Charts .chart")[1].previousElementSibling.querySelector("input").click()`);
  await browser.until(`document.querySelectorAll("#pane-Charts .chart")[1].getAttribute("aria-label").includes("logarithmic")`, "no logarithmic axis", 10);
  await browser.picture("charts.png");
  await browser.open(`${origin}/runs/${run}`);
  await browser.click("Charts");
  await browser.until(`document.querySelectorAll("#pane-Charts .chart canvas").length === 3 && document.querySelectorAll("#pane-Charts .chart")[1].getAttribute("aria-label").includes("logarithmic")`, "the charts are not kept", 20);

  // Files are shown before they are fetched.
  await browser.click("Files");
  await browser.until(`[...document.querySelectorAll("#pane-Files td")].some((cell) => cell.innerText.startsWith("drum.ene"))`, "no files", 15);
  for (const [file, part] of [["drum.ene", "time"], ["summary.json", "\"results\""], ["drum.walls.csv", "name"]]) {
    await browser.run(`[...document.querySelectorAll("#pane-Files tr")].find((row) => row.innerText.startsWith(${JSON.stringify(file)})).querySelector("button").click()`);
    await browser.until(`document.querySelector("dialog[open]")?.innerText.includes(${JSON.stringify(part)})`, `${file} is not shown`, 10);
    if (file.endsWith(".csv")) { must(await browser.run(`document.querySelectorAll("dialog[open] table tr").length > 3`), "no table"); await browser.picture("preview.png"); }
    await press("Escape");
    await browser.until(`!document.querySelector("dialog")`, "the preview stays", 5);
  }
  // After Extend the head, the steps, the particles and the picked particle are those of the new end.
  await browser.open(`${origin}/runs/${run}`);
  await browser.until(`document.querySelector(".said")?.innerText.includes("particles")`, "no particles", 30);
  const fact = (name) => `[...document.querySelectorAll("dl.facts dt")].find((one) => one.innerText === "${name}")?.nextElementSibling.innerText`;
  const [steps, time, frames] = await browser.run(`[${fact("Steps")}, parseFloat(${fact("Time")}), document.querySelector(".controls span").innerText]`);
  const later = Number((time + 0.05).toFixed(3));
  await browser.run(`fetch("/api/v1/runs/${run}/extend", { method: "POST", headers: { "content-type": "application/json" }, body: JSON.stringify({ end: ${later} }) })`);
  await browser.until(`document.querySelector(".state.queued, .state.running")`, "the head does not follow", 20);
  await browser.until(`document.querySelector(".state.finished") && parseFloat(${fact("Time")}) === ${later}`, "the time does not follow", 90);
  must(await browser.run(fact("Steps")) !== steps, `the steps are the old ones: ${steps}`);
  await browser.until(`document.querySelector(".controls span").innerText !== ${JSON.stringify(frames)} && document.querySelector(".controls span").innerText.startsWith("${later} s")`, `the particles are those of ${frames}`, 30);

  for (const [dark, width, height, name] of [[true, 1366, 768, "dark"], [false, 390, 800, "phone"]]) {
    await browser.look(width, height, dark, width < 500);
    for (const [page, what] of [[`/runs/${run}`, "run"], ["/new", "new"]]) {
      await browser.open(`${origin}${page}`);
      await sleep(2500);
      await browser.picture(`${what}-${name}.png`);
      must(await browser.run(`document.documentElement.scrollWidth <= innerWidth + 1`), `${what} is wider than the screen (${name})`);
    }
  }
  must(browser.complaints.length === 0, browser.complaints.join("\n"));
} finally {
  await browser.stop();
}
