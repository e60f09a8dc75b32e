// The frames of one run: slider, play, colour, cut; the viewer draws them.
import { bytes, get, Problem } from "./api.js";
import { el, number, put, whole } from "./dom.js";
import { reduced, Viewer } from "./viewer.js";

/** How many particles are asked for at most. */
const MOST = 100000;

/** Time of a frame in a film, in ms. */
const FRAME = 80;

/** Has the browser save a content. @param {Blob} blob @param {string} name */
function save(blob, name) {
  const link = el("a", { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60000);
}

/**
 * A frame as the server sends it: length of the head, head, ids, columns of 16 bits within their ranges.
 * @param {ArrayBuffer} buffer
 */
export function read(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  let at = 4 + length;
  const ids = new Uint32Array(buffer, at, head.rows);
  at += 4 * head.rows;
  /** @type {Record<string, {values: Float32Array, min: number, max: number}>} */
  const columns = {};
  for (const { name, min, max } of head.columns) {
    const raw = new Uint16Array(buffer, at, head.rows);
    const values = new Float32Array(head.rows);
    const scale = (max - min) / 65535;
    for (let k = 0; k < head.rows; k += 1) values[k] = min + raw[k] * scale;
    columns[name] = { values, min, max };
    at += Math.ceil((2 * head.rows) / 4) * 4;
  }
  return { time: head.time, step: head.step, rows: head.rows, of: head.of, ids, columns };
}

export class Player {
  /**
   * @param {HTMLElement} box
   * @param {{id: string}} run
   * @param {{title?: string, led?: boolean, branch?: (time: number) => void}} [options] `led`: another player chooses its frames; `branch` is called with the time that is shown
   */
  constructor(box, run, options = {}) {
    this.run = run;
    /** @type {any} */
    this.list = { frames: [], columns: [], version: "" };
    this.at = -1;
    this.follow = true;
    this.playing = 0;
    this.busy = false;
    /** @type {[number, number] | null} */
    this.range = null;
    /** Players that show the same time in the same colours. @type {Player[]} */
    this.peers = [];
    /** What is shown: draws it again, with another range. @type {{name: string, own: [number, number], paint: (range: [number, number]) => void} | null} */
    this.shown = null;
    /** The particle that was picked. @type {number | null} */
    this.picked = null;
    const stage = el("div");
    this.viewer = new Viewer(stage, { pick: (id) => this.pick(id) });
    this.slider = el("input", { type: "range", min: "0", max: "0", value: "0", class: "grow", "aria-label": "Frame", oninput: () => this.show(Number(this.slider.value), true) });
    this.play = el("button", { "aria-label": "Play", onclick: () => this.toggle() }, "▶");
    this.time = el("span", { class: "small quiet" });
    this.branch = el("button", { hidden: true, onclick: () => options.branch?.(this.list.frames[this.at]?.time ?? 0) }, "Branch here");
    this.colour = el("select", { "aria-label": "Colour", onchange: () => this.recolour() });
    this.cut = el("input", { type: "range", min: "0", max: "1000", value: "1000", "aria-label": "Cut", oninput: () => this.viewer.cut(this.axis.value, Number(this.cut.value) / 1000) });
    this.axis = el("select", { "aria-label": "Axis of the cut", onchange: () => this.viewer.cut(this.axis.value, Number(this.cut.value) / 1000) }, ["x", "y", "z"].map((axis) => el("option", { value: axis }, axis)));
    this.axis.value = "y";
    this.grain = el("div", { class: "small" });
    const walls = el("input", { type: "checkbox", checked: true, onchange: () => this.viewer.showWalls(walls.checked) });
    this.filming = false;
    this.film = el("button", { disabled: typeof MediaRecorder === "undefined", onclick: () => { if (this.filming) this.filming = false; else this.record(); } }, "Film");
    const card = el("div", { class: "card player" });
    put(box, card);
    put(card, ...this.parts(options, stage, walls, card));
    if (!this.viewer.gl) this.still(stage);
  }

  /**
   * @param {{title?: string, led?: boolean}} options
   * @param {HTMLElement} stage
   * @param {HTMLElement} walls
   * @param {HTMLElement} card
   */
  parts(options, stage, walls, card) {
    return [options.title && el("h2", {}, options.title), stage,
      el("div", { class: "row controls", hidden: options.led === true }, this.play, this.slider, this.time, this.branch),
      el("div", { class: "row small" }, el("label", {}, "Colour", this.colour), el("label", {}, "Cut", this.axis, this.cut), el("label", {}, walls, "Walls"),
        el("button", { onclick: () => this.reset() }, "Reset view"),
        this.viewer.gl && [el("button", { onclick: () => (document.fullscreenElement ? document.exitFullscreen() : card.requestFullscreen()) }, "Full screen"), el("button", { onclick: () => this.picture() }, "Picture"), this.film]), this.grain].flat(2).filter((part) => part);
  }

  /** Shows a picture of the run, where the browser draws no particles. @param {HTMLElement} stage */
  async still(stage) {
    const files = await get(`/runs/${this.run.id}/files`).catch(() => []);
    const names = files.map((/** @type {any} */ file) => file.name).filter((/** @type {string} */ name) => name.endsWith(".png"));
    const name = names.find((/** @type {string} */ name) => name.includes("final")) ?? names[0];
    if (name) stage.append(el("img", { src: `/api/v1/runs/${this.run.id}/files/${name.split("/").map(encodeURIComponent).join("/")}`, alt: `Picture ${name}`, class: "still" }));
  }

  /** Has another player show the time that this one shows, in the same colours. @param {Player} other */
  lead(other) {
    this.peers.push(other);
    other.peers.push(this);
  }

  /** Shows the colour that is chosen, also in the others. */
  recolour() {
    for (const player of [this, ...this.peers]) {
      if ([...player.colour.options].some((option) => option.value === this.colour.value)) player.colour.value = this.colour.value;
      player.range = null;
      player.shown = null;
      player.show(player.at, false, true);
    }
  }

  /** Shows the frame that is nearest to a time. @param {number} time */
  showTime(time) {
    const away = this.list.frames.map((/** @type {any} */ frame) => Math.abs(frame.time - time));
    this.follow = false;
    this.show(away.indexOf(Math.min(...away)));
  }

  /** Shows all of the domain: not turned, nothing cut away. */
  reset() {
    this.cut.value = "1000";
    this.viewer.cut(this.axis.value, 1);
    this.viewer.home();
  }

  /** Looks for new frames, and shows the last one unless the user looks at another. */
  async load() {
    if (!this.viewer.gl) return;
    const list = await get(`/runs/${this.run.id}/frames`).catch((error) => { if (error instanceof Problem && error.status === 404) return null; throw error; });
    if (!list) return;
    const anew = list.version !== this.list.version;
    this.list = list;
    const names = list.columns.map((/** @type {any} */ column) => column.name).filter((/** @type {string} */ name) => name !== "id");
    if (this.colour.options.length !== names.length) {
      const before = this.colour.value;
      put(this.colour, ...names.map((/** @type {string} */ name) => el("option", { value: name }, name)));
      if (names.includes(before)) this.colour.value = before;
    }
    this.slider.max = String(Math.max(0, list.frames.length - 1));
    if (!list.frames.length) { this.viewer.say("The first frame is still to come."); return; }
    if (this.follow || this.at < 0 || anew) await this.show(list.frames.length - 1, false, anew);
  }

  /**
   * @param {number} k
   * @param {boolean} [chosen] by the user
   * @param {boolean} [again]
   */
  async show(k, chosen = false, again = false) {
    k = Math.max(0, Math.min(k, this.list.frames.length - 1));
    if (chosen) this.follow = k === this.list.frames.length - 1;
    if ((k === this.at && !again) || this.list.frames.length === 0) return;
    // One at a time: the last wish counts.
    this.wanted = k;
    if (this.busy) return;
    this.busy = true;
    try {
      while (this.wanted !== undefined) {
        const now = this.wanted;
        this.wanted = undefined;
        const name = this.colour.value || "speed";
        const columns = name === "radius" ? "" : name;
        const [frame, walls] = await Promise.all([
          bytes(`/runs/${this.run.id}/frames/${now}?columns=${columns}&most=${MOST}&v=${this.list.version}`).then(read),
          get(`/runs/${this.run.id}/frames/${now}/walls`).catch(() => null),
        ]);
        this.at = now;
        this.slider.value = String(now);
        const unit = this.list.columns.find((/** @type {any} */ column) => column.name === name)?.unit ?? "";
        const colour = frame.columns[name];
        // While frames follow each other the legend grows with what is seen, and does not jump.
        this.range = this.range && this.playing ? [Math.min(this.range[0], colour.min), Math.max(this.range[1], colour.max)] : [colour.min, colour.max];
        const label = `${name}${unit && unit !== "1" ? ` / ${unit}` : ""}`;
        this.shown = { name, own: this.range, paint: (range) => this.viewer.frame(frame, colour.values, range, label, this.list.domain) };
        const all = [this, ...this.peers].map((player) => player.shown).filter((one) => one !== null).filter((one) => one.name === name);
        const range = /** @type {[number, number]} */ ([Math.min(...all.map((one) => one.own[0])), Math.max(...all.map((one) => one.own[1]))]);
        for (const one of all) one.paint(range);
        if (walls) this.viewer.walls(walls.walls);
        this.viewer.say((frame.rows < frame.of ? `${whole(frame.rows)} of ${whole(frame.of)} particles` : `${whole(frame.of)} particles`) + reduced(walls?.triangles));
        put(this.time, `${number(frame.time)} s · ${now + 1} of ${this.list.frames.length}`);
        if (!this.slider.closest("[hidden]")) this.peers.forEach((peer) => peer.showTime(frame.time));
        if (this.picked !== null) this.pick(this.picked);
      }
    } catch (error) {
      this.viewer.say(error instanceof Error ? error.message : String(error));
    } finally {
      this.busy = false;
    }
  }

  /** Text below a picture: run and time. */
  caption() {
    return this.list.frames.length ? `${number(this.list.frames[this.at]?.time)} s` : "";
  }

  /** Saves the view as a picture. */
  picture() {
    const canvas = document.createElement("canvas");
    this.viewer.copy(canvas, this.caption());
    canvas.toBlob((blob) => { if (blob) save(blob, `${this.run.id.slice(0, 8)}-${this.at + 1}.png`); });
  }

  /** Saves all frames as a film, as they are seen. */
  async record() {
    const canvas = document.createElement("canvas");
    this.viewer.copy(canvas, this.caption());
    const track = /** @type {any} */ (canvas.captureStream(0).getVideoTracks()[0]);
    const recorder = new MediaRecorder(new MediaStream([track]), { mimeType: "video/webm", videoBitsPerSecond: 8e6 });
    /** @type {Blob[]} */
    const pieces = [];
    recorder.ondataavailable = (event) => pieces.push(event.data);
    const ended = new Promise((done) => { recorder.onstop = done; });
    recorder.start();
    this.filming = true;
    for (let k = 0; k < this.list.frames.length && this.filming; k += 1) {
      put(this.film, `Stop the film (${k + 1} of ${this.list.frames.length})`);
      await this.show(k, true, true);
      this.viewer.copy(canvas, this.caption());
      track.requestFrame();
      await new Promise((done) => setTimeout(done, FRAME));
    }
    // The last frame is seen as long as the others.
    track.requestFrame();
    this.filming = false;
    put(this.film, "Film");
    recorder.stop();
    await ended;
    save(new Blob(pieces, { type: "video/webm" }), `${this.run.id.slice(0, 8)}.webm`);
  }

  toggle() {
    if (this.playing) { clearInterval(this.playing); this.playing = 0; } else {
      if (this.at >= this.list.frames.length - 1) this.show(0, true);
      this.playing = window.setInterval(() => {
        if (this.busy) return;
        if (this.at >= this.list.frames.length - 1) this.toggle();
        else this.show(this.at + 1, true);
      }, 80);
    }
    put(this.play, this.playing ? "⏸" : "▶");
    this.play.setAttribute("aria-label", this.playing ? "Pause" : "Play");
  }

  /** @param {number | null} id */
  async pick(id) {
    this.picked = id;
    if (id === null) return put(this.grain);
    const row = await get(`/runs/${this.run.id}/frames/${this.at}/grains/${id}`).catch(() => null);
    if (!row) put(this.grain, el("p", { class: "quiet" }, `Particle ${id} is not in this frame.`));
    else put(this.grain, el("h2", {}, `Particle ${id}`), el("dl", { class: "facts" }, row.flatMap((/** @type {any} */ one) => [el("dt", {}, one.name), el("dd", {}, `${number(one.value)} ${one.unit === "1" ? "" : one.unit}`)])));
  }

  end() {
    this.filming = false;
    clearInterval(this.playing);
    this.viewer.end();
  }
}
