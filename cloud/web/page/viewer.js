// Spheres and walls in WebGL2.
//
// A sphere is one triangle that covers it, made in the vertex shader from a texture of centres and radii; the fragment
// shader finds the point of the sphere under the pixel and writes its depth, so spheres cut walls and each other exactly.
// That is nine times as fast in software as quads with instances, and has no limit on the size of a sphere.
import { axes, Camera, distanceToSee, HALF, HOME, scaleBar } from "./camera.js";
import { el, put, whole } from "./dom.js";

/** Rows of the texture have this many spheres. */
const WIDTH = 1024;

const SPHERE_VERTEX = `#version 300 es
precision highp float;
precision highp sampler2D;
uniform sampler2D places, colours;
uniform mat4 view, projection;
uniform vec4 plane;
uniform vec2 range;
out vec2 corner;
flat out vec4 sphere;
flat out float value;
flat out int number;
const vec2 CORNERS[3] = vec2[3](vec2(-1.7320508, -1.0), vec2(1.7320508, -1.0), vec2(0.0, 2.0));
void main() {
  int k = gl_VertexID / 3;
  ivec2 at = ivec2(k % ${WIDTH}, k / ${WIDTH});
  vec4 place = texelFetch(places, at, 0);
  number = k;
  value = clamp((texelFetch(colours, at, 0).r - range.x) / max(range.y - range.x, 1e-30), 0.0, 1.0);
  if (dot(plane.xyz, place.xyz) > plane.w) { gl_Position = vec4(2.0, 2.0, 2.0, 1.0); return; }
  vec3 centre = (view * vec4(place.xyz, 1.0)).xyz;
  sphere = vec4(centre, place.w);
  corner = CORNERS[gl_VertexID % 3];
  // Seen along the line to the centre a sphere is a disc, a little larger than its radius.
  float distance = length(centre);
  float r = sphere.w;
  float apparent = r * distance / sqrt(max(distance * distance - r * r, 1e-12 * r * r));
  vec3 ahead = normalize(centre);
  vec3 right = normalize(cross(ahead, abs(ahead.y) < 0.9 ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0)));
  vec3 up = cross(right, ahead);
  gl_Position = projection * vec4(centre + (right * corner.x + up * corner.y) * apparent, 1.0);
}`;

const SPHERE_FRAGMENT = `#version 300 es
precision highp float;
uniform sampler2D map;
uniform mat4 projection;
uniform vec2 pixels;
uniform int chosen;
uniform bool picking;
in vec2 corner;
flat in vec4 sphere;
flat in float value;
flat in int number;
out vec4 colour;
void main() {
  if (dot(corner, corner) > 1.0) discard;
  vec2 screen = gl_FragCoord.xy / pixels * 2.0 - 1.0;
  vec3 ray = normalize(vec3(screen.x / projection[0][0], screen.y / projection[1][1], -1.0));
  float along = dot(ray, sphere.xyz);
  float root = along * along - dot(sphere.xyz, sphere.xyz) + sphere.w * sphere.w;
  if (root < 0.0) discard;
  vec3 point = ray * (along - sqrt(root));
  vec4 clip = projection * vec4(point, 1.0);
  gl_FragDepth = clip.z / clip.w * 0.5 + 0.5;
  if (picking) { int n = number + 1; colour = vec4(float(n & 255), float((n >> 8) & 255), float((n >> 16) & 255), 255.0) / 255.0; return; }
  vec3 normal = (point - sphere.xyz) / sphere.w;
  float light = 0.38 + 0.62 * max(dot(normal, normalize(vec3(0.35, 0.55, 0.9))), 0.0);
  vec3 base = texture(map, vec2(value, 0.5)).rgb;
  if (number == chosen) { base = mix(base, vec3(1.0, 0.15, 0.5), 0.75); light = max(light, 0.7); }
  colour = vec4(base * light, 1.0);
}`;

const WALL_VERTEX = `#version 300 es
precision highp float;
uniform mat4 view, projection;
uniform vec4 plane;
uniform vec3 origin;
uniform vec4 turn;
in vec3 place, normal;
out vec3 facing;
out float behind;
vec3 turned(vec3 v) { return v + 2.0 * cross(turn.xyz, cross(turn.xyz, v) + turn.w * v); }
void main() {
  vec3 global = turned(place) + origin;
  behind = dot(plane.xyz, global) - plane.w;
  facing = mat3(view) * turned(normal);
  gl_Position = projection * view * vec4(global, 1.0);
}`;

const WALL_FRAGMENT = `#version 300 es
precision highp float;
uniform vec3 ink;
in vec3 facing;
in float behind;
out vec4 colour;
void main() {
  if (behind > 0.0) discard;
  float light = 0.35 + 0.65 * abs(normalize(facing).z);
  colour = vec4(ink * light, 1.0) * 0.3;
}`;

/** Values of viridis at equal distances (van der Walt and Smith, 2015). */
const VIRIDIS = [[68, 1, 84], [72, 40, 120], [62, 74, 137], [49, 104, 142], [38, 130, 142], [31, 158, 137], [53, 183, 121], [109, 205, 89], [180, 222, 44], [253, 231, 37]];

/** @param {number} x from 0 to 1 */
function viridis(x) {
  const at = Math.min(VIRIDIS.length - 1.000001, Math.max(0, x * (VIRIDIS.length - 1)));
  const k = Math.floor(at);
  return [0, 1, 2].map((c) => Math.round(VIRIDIS[k][c] + (VIRIDIS[k + 1][c] - VIRIDIS[k][c]) * (at - k)));
}

/** @typedef {{pick?: (id: number | null) => void, height?: string}} Options */

/** A note that walls are shown with fewer triangles than they have. @param {[number, number] | undefined} triangles shown, and all */
export const reduced = (triangles) => triangles && triangles[0] < triangles[1] ? ` · walls reduced from ${whole(triangles[1])} to ${whole(triangles[0])} triangles` : "";

export class Viewer {
  /**
   * @param {HTMLElement} box
   * @param {Options} [options]
   */
  constructor(box, options = {}) {
    this.options = options;
    this.canvas = el("canvas", { tabindex: "0", role: "img", "aria-label": "Particles and walls. Arrow keys turn, plus and minus zoom." });
    if (options.height) this.canvas.style.height = options.height;
    /** Axes and scale bar. */
    this.over = el("canvas", { class: "over", "aria-hidden": "true" });
    this.legend = el("div", { class: "legend", hidden: true });
    this.said = el("div", { class: "said", hidden: true });
    this.box = el("div", { class: "viewer" }, this.canvas, this.over, this.legend, this.said);
    put(box, this.box);
    this.what = "";
    this.camera = new Camera();
    this.draw = () => this.soon();
    this.camera.seen.add(this.draw);
    this.count = 0;
    /** @type {Uint32Array} */
    this.ids = new Uint32Array();
    this.range = [0, 1];
    this.chosen = -1;
    /** @type {{centre: number[], radius: number}} */
    this.ball = { centre: [0, 0, 0], radius: 1 };
    this.framed = "";
    this.plane = [0, 0, 0, 1];
    /** @type {number[][] | null} */
    this.domain = null;
    this.wallsShown = true;
    /** @type {{name: string, present: boolean, pose: number[], buffer: WebGLBuffer, vao: WebGLVertexArrayObject, count: number, key: string}[]} */
    this.meshes = [];
    this.moving = 0;
    this.last = 0;
    /** @type {WebGL2RenderingContext} */
    this.gl = /** @type {any} */ (this.canvas.getContext("webgl2", { antialias: false, alpha: true }));
    if (!this.gl) { this.canvas.style.height = "4rem"; this.say("This browser draws no particles: it has no WebGL2. A picture of the run is shown instead, once there is one."); return; }
    this.prepare();
    this.watch = new ResizeObserver(() => this.soon());
    this.watch.observe(this.canvas);
    this.listen();
  }

  prepare() {
    const gl = this.gl;
    /** @param {string} vertex @param {string} fragment */
    const program = (vertex, fragment) => {
      const made = /** @type {WebGLProgram} */ (gl.createProgram());
      for (const [kind, text] of /** @type {[number, string][]} */ ([[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]])) {
        const shader = /** @type {WebGLShader} */ (gl.createShader(kind));
        gl.shaderSource(shader, text);
        gl.compileShader(shader);
        if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader) ?? "shader");
        gl.attachShader(made, shader);
      }
      gl.linkProgram(made);
      /** @type {Map<string, WebGLUniformLocation | null>} */
      const places = new Map();
      return { made, at: (/** @type {string} */ name) => { if (!places.has(name)) places.set(name, gl.getUniformLocation(made, name)); return places.get(name) ?? null; } };
    };
    this.spheres = program(SPHERE_VERTEX, SPHERE_FRAGMENT);
    this.wall = program(WALL_VERTEX, WALL_FRAGMENT);
    const texture = (/** @type {number} */ filter) => {
      const made = gl.createTexture();
      gl.bindTexture(gl.TEXTURE_2D, made);
      for (const [name, value] of [[gl.TEXTURE_MIN_FILTER, filter], [gl.TEXTURE_MAG_FILTER, filter], [gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE], [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE]]) gl.texParameteri(gl.TEXTURE_2D, name, value);
      return made;
    };
    this.places = texture(gl.NEAREST);
    this.colours = texture(gl.NEAREST);
    this.map = texture(gl.LINEAR);
    const map = new Uint8Array(Array.from({ length: 256 }, (_, k) => [...viridis(k / 255), 255]).flat());
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, 256, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, map);
    this.empty = gl.createVertexArray();
  }

  listen() {
    const { canvas, camera } = this;
    /** @type {Map<number, PointerEvent>} */
    const fingers = new Map();
    let moved = 0;
    let apart = 0;
    canvas.addEventListener("pointerdown", (/** @type {PointerEvent} */ event) => { canvas.setPointerCapture(event.pointerId); fingers.set(event.pointerId, event); moved = 0; apart = 0; });
    canvas.addEventListener("pointermove", (/** @type {PointerEvent} */ event) => {
      const before = fingers.get(event.pointerId);
      if (!before) return;
      const [dx, dy] = [event.clientX - before.clientX, event.clientY - before.clientY];
      fingers.set(event.pointerId, event);
      moved += Math.abs(dx) + Math.abs(dy);
      if (fingers.size === 2) {
        const [a, b] = [...fingers.values()];
        const now = Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY);
        if (apart) camera.zoom = clamp(camera.zoom * (apart / now), 0.02, 20);
        apart = now;
      } else if (event.buttons & 2 || event.shiftKey) {
        camera.shift[0] -= dx / canvas.clientHeight;
        camera.shift[1] += dy / canvas.clientHeight;
      } else {
        this.camera.azimuth -= dx * 0.008;
        this.camera.elevation = clamp(this.camera.elevation + dy * 0.008, -1.55, 1.55);
      }
      this.move();
    });
    const up = (/** @type {PointerEvent} */ event) => {
      const was = fingers.delete(event.pointerId);
      if (was && moved < 4 && event.type === "pointerup") this.pickAt(event.offsetX, event.offsetY);
    };
    canvas.addEventListener("pointerup", up);
    canvas.addEventListener("pointercancel", up);
    canvas.addEventListener("contextmenu", (/** @type {Event} */ event) => event.preventDefault());
    canvas.addEventListener("wheel", (/** @type {WheelEvent} */ event) => {
      event.preventDefault();
      this.camera.zoom = clamp(this.camera.zoom * Math.exp(event.deltaY * 0.0012), 0.02, 20);
      this.move();
    }, { passive: false });
    canvas.addEventListener("keydown", (/** @type {KeyboardEvent} */ event) => {
      /** @type {Record<string, () => void>} */
      const keys = {
        ArrowLeft: () => { this.camera.azimuth -= 0.1; }, ArrowRight: () => { this.camera.azimuth += 0.1; },
        ArrowUp: () => { this.camera.elevation = clamp(this.camera.elevation + 0.1, -1.55, 1.55); }, ArrowDown: () => { this.camera.elevation = clamp(this.camera.elevation - 0.1, -1.55, 1.55); },
        "+": () => { this.camera.zoom *= 0.9; }, "=": () => { this.camera.zoom *= 0.9; }, "-": () => { this.camera.zoom /= 0.9; }, Home: () => this.home(),
      };
      if (keys[event.key]) { event.preventDefault(); keys[event.key](); this.move(); }
    });
  }

  /** Looks the same way as another viewer from now on. @param {Viewer} other */
  share(other) {
    other.camera.seen.delete(other.draw);
    other.camera = this.camera;
    this.camera.seen.add(other.draw);
    // The listeners of the other one turn the camera that is its own now.
    other.move = () => { other.moving = performance.now(); this.camera.changed(); };
  }

  move() {
    this.moving = performance.now();
    this.camera.changed();
    clearTimeout(this.rest);
    this.rest = setTimeout(() => this.camera.changed(), 260);
  }

  home() {
    Object.assign(this.camera, { ...HOME, zoom: 1, shift: [0, 0] });
    this.camera.changed();
  }

  /** @param {string} text */
  say(text) {
    this.said.hidden = !text;
    put(this.said, text);
  }

  /** @param {boolean} shown */
  showWalls(shown) {
    this.wallsShown = shown;
    this.soon();
  }

  /** @param {string} axis @param {number} share 1: nothing is cut */
  cut(axis, share) {
    const normal = [0, 0, 0];
    const k = "xyz".indexOf(axis);
    if (share < 1 && this.domain) {
      normal[k] = 1;
      this.plane = [...normal, this.domain[0][k] + share * (this.domain[1][k] - this.domain[0][k])];
    } else this.plane = [0, 0, 0, 1];
    this.soon();
  }

  /**
   * @param {{rows: number, ids: Uint32Array, columns: Record<string, {values: Float32Array}>}} frame
   * @param {Float32Array} values
   * @param {number[]} range
   * @param {string} what
   * @param {number[][] | null} domain
   */
  frame(frame, values, range, what, domain) {
    if (!this.gl) return;
    const chosen = this.chosen >= 0 ? this.ids[this.chosen] : -1;
    this.ids = frame.ids;
    this.chosen = chosen >= 0 ? this.ids.indexOf(chosen) : -1;
    const { x, y, z, radius } = frame.columns;
    this.fill(frame.rows, x.values, y.values, z.values, radius.values, values);
    this.range = range;
    this.look(domain);
    this.describe(range, what);
    this.soon();
  }

  /** Frame and walls of a preview. @param {any} seen */
  still(seen) {
    if (!this.gl) return;
    const [x, y, z, radius] = seen.grains.map((/** @type {number[]} */ column) => Float32Array.from(column));
    this.ids = Uint32Array.from(x.keys());
    this.fill(x.length, x, y, z, radius, radius);
    const least = Math.min(...radius.slice(0, 50000));
    const largest = Math.max(...radius.slice(0, 50000));
    this.range = largest > least ? [least, largest] : [0, 2 * largest || 1];
    this.look(seen.domain);
    this.walls(seen.walls?.walls ?? []);
    this.say((x.length ? `${x.length} particles at the start` : "No particle yet: they are inserted later.") + reduced(seen.walls?.triangles));
    this.soon();
  }

  /**
   * @param {number} count @param {Float32Array} x @param {Float32Array} y @param {Float32Array} z
   * @param {Float32Array} radius @param {Float32Array} values
   */
  fill(count, x, y, z, radius, values) {
    const gl = this.gl;
    const rows = Math.max(1, Math.ceil(count / WIDTH));
    const places = new Float32Array(4 * WIDTH * rows);
    const colours = new Float32Array(WIDTH * rows);
    for (let k = 0; k < count; k += 1) { places[4 * k] = x[k]; places[4 * k + 1] = y[k]; places[4 * k + 2] = z[k]; places[4 * k + 3] = radius[k]; }
    colours.set(values.subarray(0, count));
    gl.bindTexture(gl.TEXTURE_2D, this.places ?? null);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, WIDTH, rows, 0, gl.RGBA, gl.FLOAT, places);
    gl.bindTexture(gl.TEXTURE_2D, this.colours ?? null);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.R32F, WIDTH, rows, 0, gl.RED, gl.FLOAT, colours);
    this.count = count;
  }

  /** Looks at the whole domain, once for each. @param {number[][] | null} domain */
  look(domain) {
    if (!domain || this.framed === JSON.stringify(domain)) return;
    this.framed = JSON.stringify(domain);
    this.domain = domain;
    const [min, max] = domain;
    this.ball = { centre: min.map((low, k) => (low + max[k]) / 2), radius: Math.hypot(...min.map((low, k) => max[k] - low)) / 2 || 1 };
  }

  /** @param {{name: string, present: boolean, pose: number[], corners: number[]}[]} walls */
  walls(walls) {
    const gl = this.gl;
    if (!gl || !this.wall) return;
    const before = this.meshes;
    this.meshes = walls.map((wall, k) => {
      // Triangles are those of before, at other places.
      const key = `${wall.corners.length}:${wall.corners.slice(0, 18).join()}`;
      const same = before[k]?.key === key ? before[k] : null;
      if (same) return { ...same, present: wall.present, pose: wall.pose };
      if (before[k]) { gl.deleteBuffer(before[k].buffer); gl.deleteVertexArray(before[k].vao); }
      const corners = wall.corners;
      const data = new Float32Array(corners.length * 2);
      for (let t = 0; t < corners.length; t += 9) {
        const [ux, uy, uz] = [0, 1, 2].map((c) => corners[t + 3 + c] - corners[t + c]);
        const [vx, vy, vz] = [0, 1, 2].map((c) => corners[t + 6 + c] - corners[t + c]);
        const normal = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
        const length = Math.hypot(...normal) || 1;
        for (let c = 0; c < 3; c += 1) data.set([...corners.slice(t + 3 * c, t + 3 * c + 3), ...normal.map((n) => n / length)], 2 * t + 6 * c);
      }
      const vao = /** @type {WebGLVertexArrayObject} */ (gl.createVertexArray());
      const buffer = /** @type {WebGLBuffer} */ (gl.createBuffer());
      gl.bindVertexArray(vao);
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
      ["place", "normal"].forEach((name, n) => {
        const at = gl.getAttribLocation(/** @type {any} */ (this.wall).made, name);
        if (at < 0) return;
        gl.enableVertexAttribArray(at);
        gl.vertexAttribPointer(at, 3, gl.FLOAT, false, 24, 12 * n);
      });
      return { name: wall.name, present: wall.present, pose: wall.pose, buffer, vao, count: corners.length / 3, key };
    });
    for (const mesh of before.slice(walls.length)) { gl.deleteBuffer(mesh.buffer); gl.deleteVertexArray(mesh.vao); }
    this.soon();
  }

  /** @param {number[]} range @param {string} what */
  describe(range, what) {
    const bar = el("canvas", { width: 120, height: 10 });
    colours(bar.getContext("2d"), 0, 0, 120, 10);
    this.what = what;
    put(this.legend, el("span", {}, what), bar, el("div", { class: "ends" }, el("span", {}, short(range[0])), el("span", {}, short(range[1]))));
    this.legend.hidden = false;
  }

  /** Directions of the axes, and a scale bar for what is as far as the middle of the domain. @param {number} dense pixels of a CSS pixel */
  mark(dense) {
    const { width, height } = this.canvas;
    if (this.over.width !== width || this.over.height !== height) { this.over.width = width; this.over.height = height; }
    const ink = this.over.getContext("2d");
    const colour = getComputedStyle(this.box).color;
    ink.setTransform(dense, 0, 0, dense, 0, 0);
    const [wide, high] = [width / dense, height / dense];
    ink.clearRect(0, 0, wide, high);
    Object.assign(ink, { font: "12px system-ui, sans-serif", lineWidth: 2, textAlign: "center", textBaseline: "middle" });
    const { right, up, back } = axes(this.camera);
    // The one that points away is drawn first.
    for (const c of [0, 1, 2].sort((a, b) => back[a] - back[b])) {
      const [x, y] = [right[c], -up[c]];
      ink.strokeStyle = ink.fillStyle = AXES[c];
      ink.beginPath();
      ink.moveTo(44, high - 78);
      ink.lineTo(44 + 26 * x, high - 78 + 26 * y);
      ink.stroke();
      ink.fillText("xyz"[c], 44 + 36 * x, high - 78 + 36 * y);
    }
    const { pixels, label } = scaleBar(high / (2 * HALF * this.distance()), Math.min(140, wide / 3));
    ink.strokeStyle = ink.fillStyle = colour;
    ink.beginPath();
    for (const [x, y] of [[wide - 16 - pixels, high - 20], [wide - 16 - pixels, high - 14], [wide - 16, high - 14], [wide - 16, high - 20]]) ink.lineTo(x, y);
    ink.stroke();
    ink.fillText(label, wide - 16 - pixels / 2, high - 26);
    this.box.dataset.bar = `${label} ${pixels.toFixed(0)}`;
  }

  /** The view as a picture, with legend, axes, scale bar and a text. @param {HTMLCanvasElement} picture @param {string} text */
  copy(picture, text) {
    this.paint(false);
    const { width, height } = this.canvas;
    // Films need even numbers of pixels.
    [picture.width, picture.height] = [width - (width % 2), height - (height % 2)];
    const ink = /** @type {CanvasRenderingContext2D} */ (picture.getContext("2d"));
    const style = getComputedStyle(this.box);
    const dense = width / this.canvas.clientWidth;
    ink.fillStyle = style.backgroundColor;
    ink.fillRect(0, 0, width, height);
    ink.drawImage(this.canvas, 0, 0);
    ink.drawImage(this.over, 0, 0);
    ink.scale(dense, dense);
    const wide = width / dense;
    Object.assign(ink, { fillStyle: style.color, font: "12px system-ui, sans-serif", textBaseline: "top" });
    ink.fillText(text, 12, height / dense - 24);
    if (this.legend.hidden) return;
    ink.fillText(this.what, wide - 136, 12);
    colours(ink, wide - 136, 30, 120, 10);
    ink.fillText(short(this.range[0]), wide - 136, 44);
    ink.textAlign = "right";
    ink.fillText(short(this.range[1]), wide - 16, 44);
  }

  soon() {
    if (!this.gl || this.due) return;
    this.due = requestAnimationFrame(() => { this.due = 0; this.paint(false); });
  }

  aspect() {
    return Math.max(this.canvas.clientWidth, 1) / Math.max(this.canvas.clientHeight, 1);
  }

  /** Distance of the camera from the middle of the domain. */
  distance() {
    const aspect = this.aspect();
    return this.camera.zoom * (this.domain ? distanceToSee(this.domain, aspect) : this.ball.radius / (HALF * Math.min(1, aspect)));
  }

  matrices() {
    const { ball } = this;
    const { shift } = this.camera;
    const [aspect, distance, half] = [this.aspect(), this.distance(), HALF];
    const { back, right, up } = axes(this.camera);
    const reach = 2 * half * distance;
    const eye = [0, 1, 2].map((c) => ball.centre[c] + back[c] * distance + (right[c] * shift[0] + up[c] * shift[1]) * reach);
    /** @param {number[]} a */
    const along = (a) => -(a[0] * eye[0] + a[1] * eye[1] + a[2] * eye[2]);
    const view = new Float32Array([right[0], up[0], back[0], 0, right[1], up[1], back[1], 0, right[2], up[2], back[2], 0, along(right), along(up), along(back), 1]);
    const near = Math.max(distance - 3 * ball.radius, distance * 0.01);
    const far = distance + 3 * ball.radius;
    const projection = new Float32Array([1 / (half * aspect), 0, 0, 0, 0, 1 / half, 0, 0, 0, 0, -(far + near) / (far - near), -1, 0, 0, (-2 * far * near) / (far - near), 0]);
    return { view, projection };
  }

  /** @param {boolean} picking */
  paint(picking) {
    const { gl, canvas, spheres, wall } = this;
    if (!spheres || !wall) return;
    const dense = Math.min(devicePixelRatio || 1, 2);
    const [width, height] = [Math.max(1, Math.round(canvas.clientWidth * dense)), Math.max(1, Math.round(canvas.clientHeight * dense))];
    if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; }
    const begin = performance.now();
    const { view, projection } = this.matrices();
    gl.viewport(0, 0, width, height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.disable(gl.BLEND);
    gl.useProgram(spheres.made);
    gl.bindVertexArray(this.empty ?? null);
    [this.places, this.colours, this.map].forEach((texture, k) => { gl.activeTexture(gl.TEXTURE0 + k); gl.bindTexture(gl.TEXTURE_2D, texture ?? null); });
    ["places", "colours", "map"].forEach((name, k) => gl.uniform1i(spheres.at(name), k));
    gl.activeTexture(gl.TEXTURE0);
    gl.uniformMatrix4fv(spheres.at("view"), false, view);
    gl.uniformMatrix4fv(spheres.at("projection"), false, projection);
    gl.uniform4fv(spheres.at("plane"), this.plane);
    gl.uniform2fv(spheres.at("range"), this.range);
    gl.uniform2f(spheres.at("pixels"), width, height);
    gl.uniform1i(spheres.at("chosen"), this.chosen);
    gl.uniform1i(spheres.at("picking"), picking ? 1 : 0);
    // While the camera moves, a slow machine draws a part. The server has put the grains in an order of which any first part
    // is spread over all.
    const few = !picking && performance.now() - this.moving < 250 && this.last > 50;
    gl.drawArrays(gl.TRIANGLES, 0, 3 * (few ? Math.min(this.count, 20000) : this.count));
    if (picking) return;
    if (this.wallsShown) {
      gl.useProgram(wall.made);
      gl.uniformMatrix4fv(wall.at("view"), false, view);
      gl.uniformMatrix4fv(wall.at("projection"), false, projection);
      gl.uniform4fv(wall.at("plane"), this.plane);
      const dark = matchMedia("(prefers-color-scheme: dark)").matches;
      gl.uniform3fv(wall.at("ink"), dark ? [0.62, 0.72, 0.82] : [0.3, 0.38, 0.46]);
      gl.enable(gl.BLEND);
      gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
      gl.depthMask(false);
      for (const mesh of this.meshes) {
        if (!mesh.present) continue;
        gl.uniform3fv(wall.at("origin"), mesh.pose.slice(0, 3));
        gl.uniform4f(wall.at("turn"), mesh.pose[4], mesh.pose[5], mesh.pose[6], mesh.pose[3]);
        gl.bindVertexArray(mesh.vao);
        gl.drawArrays(gl.TRIANGLES, 0, mesh.count);
      }
      gl.depthMask(true);
    }
    if (!few && this.count > 20000) {
      // A pixel that is read is the only certain end of drawing.
      gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
      this.last = performance.now() - begin;
    }
    this.mark(dense);
    canvas.dataset.frames = String(Number(canvas.dataset.frames ?? 0) + 1);
    canvas.dataset.ms = this.last.toFixed(0);
  }

  /** @param {number} x @param {number} y */
  pickAt(x, y) {
    const gl = this.gl;
    if (!gl || !this.options.pick) return;
    this.paint(true);
    const dense = this.canvas.width / this.canvas.clientWidth;
    const pixel = new Uint8Array(4);
    gl.readPixels(Math.round(x * dense), this.canvas.height - 1 - Math.round(y * dense), 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
    const number = pixel[0] + 256 * pixel[1] + 65536 * pixel[2] - 1;
    this.chosen = pixel[3] === 255 && number >= 0 && number < this.count ? number : -1;
    this.options.pick(this.chosen >= 0 ? this.ids[this.chosen] : null);
    this.soon();
  }

  end() {
    cancelAnimationFrame(this.due ?? 0);
    clearTimeout(this.rest);
    this.camera.seen.delete(this.draw);
    this.watch?.disconnect();
    this.gl?.getExtension("WEBGL_lose_context")?.loseContext();
  }
}

/** Colours of the axes x, y and z, to be seen on light and dark. */
const AXES = ["#d9534f", "#3c9a67", "#3f8fd0"];

/** The scale of colours as a bar. @param {CanvasRenderingContext2D} ink @param {number} x @param {number} y @param {number} width @param {number} height */
function colours(ink, x, y, width, height) {
  for (let k = 0; k < width; k += 1) { ink.fillStyle = `rgb(${viridis(k / (width - 1)).join()})`; ink.fillRect(x + k, y, 1, height); }
  ink.fillStyle = getComputedStyle(document.body).color;
}

/** @param {number} value */
const short = (value) => String(Number(value.toPrecision(3)));

/** @param {number} value @param {number} low @param {number} high */
function clamp(value, low, high) {
  return Math.min(high, Math.max(low, value));
}
