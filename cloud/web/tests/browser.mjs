// A headless Chromium, driven by its DevTools protocol. Node's own WebSocket and fetch; nothing from npm.
import { spawn, spawnSync } from "node:child_process";
import { mkdirSync, mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

export const sleep = (ms) => new Promise((done) => setTimeout(done, ms));

// Before version 22 Node has it behind a flag, and before 20.10 not at all.
if (typeof WebSocket === "undefined") {
  if (process.execArgv.includes("--experimental-websocket")) throw new Error("Node 20.10 or later is needed");
  process.exit(spawnSync(process.execPath, ["--experimental-websocket", ...process.argv.slice(1)], { stdio: "inherit" }).status ?? 1);
}

export class Browser {
  static async start() {
    const browser = new Browser();
    browser.folder = mkdtempSync(join(tmpdir(), "newcomer-"));
    const options = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update",
      "--disable-sync", "--enable-unsafe-swiftshader", "--use-angle=swiftshader", "--remote-debugging-port=0", `--user-data-dir=${browser.folder}`, "about:blank"];
    browser.process = spawn(process.env.CHROMIUM ?? "chromium", options, { stdio: ["ignore", "ignore", "pipe"] });
    const port = await new Promise((done, failed) => {
      let text = "";
      browser.process.stderr.on("data", (data) => { text += data; const found = text.match(/ws:\/\/127\.0\.0\.1:(\d+)\//); if (found) done(found[1]); });
      browser.process.on("exit", () => failed(new Error(`Chromium ended:\n${text}`)));
    });
    const page = (await (await fetch(`http://127.0.0.1:${port}/json`)).json()).find((one) => one.type === "page");
    browser.socket = new WebSocket(page.webSocketDebuggerUrl);
    await new Promise((done) => browser.socket.addEventListener("open", done));
    browser.next = 1;
    browser.waiting = new Map();
    /** Errors of the console, the network and the policy. */
    browser.complaints = [];
    browser.socket.addEventListener("message", (event) => {
      const message = JSON.parse(event.data);
      if (message.id) { browser.waiting.get(message.id)?.(message); browser.waiting.delete(message.id); }
      const { method, params } = message;
      if (method === "Runtime.exceptionThrown") browser.complaints.push(params.exceptionDetails.exception?.description ?? params.exceptionDetails.text);
      if (method === "Runtime.consoleAPICalled" && ["error", "warning", "assert"].includes(params.type)) browser.complaints.push(params.args.map((arg) => arg.value ?? arg.description).join(" "));
      if (method === "Log.entryAdded" && params.entry.level === "error") browser.complaints.push(`${params.entry.text} ${params.entry.url ?? ""}`);
      if (method === "Page.javascriptDialogOpening") { browser.complaints.push(`dialog: ${params.message}`); browser.send("Page.handleJavaScriptDialog", { accept: false }); }
    });
    for (const domain of ["Page", "Runtime", "Log", "Network"]) await browser.send(`${domain}.enable`);
    return browser;
  }

  async send(method, params = {}) {
    const id = this.next++;
    this.socket.send(JSON.stringify({ id, method, params }));
    const answer = await new Promise((done) => this.waiting.set(id, done));
    if (answer.error) throw new Error(`${method}: ${answer.error.message}`);
    return answer.result;
  }

  /** Evaluates an expression in the page. */
  async run(expression) {
    const { result, exceptionDetails } = await this.send("Runtime.evaluate", { expression, awaitPromise: true, returnByValue: true });
    if (exceptionDetails) throw new Error(exceptionDetails.exception?.description ?? exceptionDetails.text);
    return result.value;
  }

  async until(expression, what, seconds = 60) {
    const end = Date.now() + 1000 * seconds;
    while (Date.now() < end) {
      const found = await this.run(expression).catch(() => null);
      if (found) return found;
      await sleep(150);
    }
    await this.picture("failed.png").catch(() => {});
    throw new Error(`${what}: not within ${seconds} s. The page says:\n${await this.run("document.body.innerText").catch(() => "")}\n${this.complaints.join("\n")}`);
  }

  async open(url) {
    await this.send("Page.navigate", { url });
    await sleep(300);
  }

  /** Clicks the button or link with this text, as a user does. A page that changes in that moment may miss the click: then once more. */
  async click(text) {
    const named = `(one) => one?.innerText.trim().startsWith(${JSON.stringify(text)})`;
    const place = `(() => {
      const named = ${named}, buttons = "button, a, [role=tab]";
      const one = [...document.querySelectorAll(buttons)].find((one) => named(one) && one.offsetParent && !one.disabled);
      if (!one) return null;
      window.clicked = false;
      addEventListener("click", (event) => { window.clicked = Boolean(named(event.target.closest(buttons))); }, { once: true, capture: true });
      one.scrollIntoView({ block: "center" });
      const box = one.getBoundingClientRect();
      return [box.x + box.width / 2, box.y + box.height / 2];
    })()`;
    for (let tries = 0; tries < 5; tries++) {
      const [x, y] = await this.until(place, `no ${text}`);
      for (const type of ["mousePressed", "mouseReleased"]) await this.send("Input.dispatchMouseEvent", { type, x, y, button: "left", clickCount: 1 });
      // A new page knows nothing of it.
      if (await this.run("window.clicked").catch(() => undefined) !== false) return;
    }
    throw new Error(`${text} does not take a click`);
  }

  async look(width, height, dark, mobile = false) {
    await this.send("Emulation.setDeviceMetricsOverride", { width, height, deviceScaleFactor: 1, mobile });
    await this.send("Emulation.setEmulatedMedia", { features: [{ name: "prefers-color-scheme", value: dark ? "dark" : "light" }] });
    await sleep(700);
  }

  async picture(name) {
    const folder = process.env.PICTURES;
    if (!folder) return;
    const { data } = await this.send("Page.captureScreenshot", { format: "png", captureBeyondViewport: false });
    mkdirSync(folder, { recursive: true });
    writeFileSync(join(folder, name), Buffer.from(data, "base64"));
  }

  async stop() {
    this.socket.close();
    const ended = new Promise((done) => this.process.on("exit", done));
    this.process.kill("SIGKILL");
    await ended;
    // Processes of the browser may write for a moment after its end.
    await sleep(500);
    rmSync(this.folder, { recursive: true, force: true, maxRetries: 10, retryDelay: 300 });
  }
}
