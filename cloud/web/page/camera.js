// A camera that turns about a point: its axes, its distance, and the length of a scale bar.

/** Direction of a view that was not turned, in radians. */
export const HOME = { azimuth: -1.05, elevation: 0.28 };

/** Tangent of half the angle that a view has from top to bottom. */
export const HALF = Math.tan(0.3);

/** Axes of a camera: back to it, right and up. @param {{azimuth: number, elevation: number}} camera */
export function axes({ azimuth, elevation }) {
  const back = [Math.cos(elevation) * Math.cos(azimuth), Math.cos(elevation) * Math.sin(azimuth), Math.sin(elevation)];
  const right = [-Math.sin(azimuth), Math.cos(azimuth), 0];
  const up = [back[1] * right[2] - back[2] * right[1], back[2] * right[0] - back[0] * right[2], back[0] * right[1] - back[1] * right[0]];
  return { back, right, up };
}

/**
 * Distance from the middle of a box at which a camera that was not turned sees all corners of it, with a margin.
 * @param {number[][]} domain least and largest corner
 * @param {number} aspect width of the view by its height
 */
export function distanceToSee([min, max], aspect) {
  const { back, right, up } = axes(HOME);
  /** @param {number[]} a @param {number[]} b */
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  let distance = 0;
  for (let k = 0; k < 8; k += 1) {
    const corner = [0, 1, 2].map((c) => ((k >> c) & 1 ? 0.5 : -0.5) * (max[c] - min[c]));
    distance = Math.max(distance, dot(corner, back) + Math.max(Math.abs(dot(corner, right)) / aspect, Math.abs(dot(corner, up))) / HALF);
  }
  return 1.06 * distance || 1;
}

/**
 * A scale bar: its length is 1, 2 or 5 times a power of ten.
 * @param {number} density pixels of a metre
 * @param {number} most its largest length in pixels
 */
export function scaleBar(density, most) {
  const largest = most / density;
  const power = 10 ** Math.floor(Math.log10(largest));
  const metres = [5, 2, 1].map((digit) => digit * power).find((length) => length <= largest * (1 + 1e-9)) ?? power;
  const [unit, size] = /** @type {[string, number]} */ ([["km", 1e3], ["m", 1], ["mm", 1e-3], ["µm", 1e-6], ["nm", 1e-9]].find(([, size]) => metres >= Number(size) * (1 - 1e-9)) ?? ["m", 1]);
  return { pixels: metres * density, label: `${Number((metres / size).toPrecision(1))} ${unit}` };
}

/** A camera that turns about a point. Shared by viewers that look the same way. */
export class Camera {
  constructor() {
    this.azimuth = HOME.azimuth;
    this.elevation = HOME.elevation;
    this.zoom = 1;
    this.shift = [0, 0];
    /** @type {Set<() => void>} */
    this.seen = new Set();
  }

  changed() { this.seen.forEach((draw) => draw()); }
}
