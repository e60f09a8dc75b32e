// Charts of table columns over time; uPlot draws, the server has reduced them.
import { el } from "./dom.js";
import uPlot from "./vendor/uPlot.esm.js";

const COLOURS = ["#2f7fb8", "#d98a2b", "#3c9a67", "#c0504d", "#8064a2", "#6b8e23", "#008b8b", "#b8860b"];

/** As many digits as tell neighbours apart; a step of 0.25 needs one more than its size says. @param {any} _ @param {number[]} values */
const ticks = (_, values) => {
  const step = values.length > 1 ? Math.abs(values[1] - values[0]) : Math.abs(values[0] ?? 1) || 1;
  const largest = Math.max(...values.map(Math.abs));
  const decimals = Math.max(0, Math.ceil(-Math.log10(step) - 1e-6));
  const digits = Math.max(0, Math.ceil(Math.log10(largest / step) - 1e-6));
  const plain = largest < 1e5 && largest >= 1e-3;
  return values.map((value) => (Math.abs(value) < 1e-9 * step ? "0" : plain ? String(Number(value.toFixed(decimals + 1))) : value.toExponential(Math.min(digits, 8)).replace("e+", "e")));
};

/** Ticks of a logarithmic axis; those between powers of ten may be left without a number. @param {any} _ @param {(number | null)[]} values */
const powers = (_, values) => values.map((value) => (value == null ? "" : value >= 1e-3 && value < 1e5 ? String(Number(value.toPrecision(3))) : value.toExponential(0).replace("e+", "e")));

/** The value at the pointer, or a dash. @param {string} unit */
const shown = (unit) => (/** @type {any} */ _, /** @type {number | null | undefined} */ value) => {
  if (value == null) return "–";
  const plain = value === 0 || (Math.abs(value) >= 1e-3 && Math.abs(value) < 1e6);
  return `${plain ? Number(value.toPrecision(5)) : value.toExponential(4)}${unit && ` ${unit}`}`;
};

/** @typedef {{label: string, chart: {time: number[], min: (number | null)[], max: (number | null)[]}}} Curve */

/**
 * Draws curves over each other into a box. Returns what removes them.
 * @param {HTMLElement} box
 * @param {string} title
 * @param {Curve[]} curves
 * @param {{time: boolean, value: boolean}} [log] logarithmic axes; values that are not positive are left out of them
 * @returns {() => void}
 */
export function draw(box, title, curves, log = { time: false, value: false }) {
  const style = getComputedStyle(document.documentElement);
  const [text, line] = ["--quiet", "--line"].map((name) => style.getPropertyValue(name).trim());
  const times = [...new Set(curves.flatMap((curve) => curve.chart.time))].filter((time) => !log.time || time > 0).sort((a, b) => a - b);
  const at = new Map(times.map((time, k) => [time, k]));
  /** @param {Curve} curve @param {(number | null)[]} values */
  const spread = (curve, values) => {
    const all = new Array(times.length).fill(undefined);
    curve.chart.time.forEach((time, k) => { const place = at.get(time); if (place !== undefined) all[place] = log.value && !((values[k] ?? 0) > 0) ? null : values[k]; });
    return all;
  };
  // Where bins have more than one row, the band from least to largest is the curve.
  const banded = (/** @type {Curve} */ curve) => curve.chart.min.some((value, k) => value !== curve.chart.max[k]);
  // As in "Energies / J".
  const unit = title.split(" / ")[1] ?? "";
  const series = /** @type {any[]} */ ([{ label: "time", value: shown("s") }]);
  const data = [times];
  const bands = /** @type {any[]} */ ([]);
  curves.forEach((curve, k) => {
    const stroke = COLOURS[k % COLOURS.length];
    series.push({ label: curve.label, stroke, value: shown(unit), width: 1.6, spanGaps: true, points: { show: curve.chart.time.length < 30 } });
    data.push(spread(curve, curve.chart.max));
    if (banded(curve)) {
      series.push({ label: `${curve.label} least`, stroke, value: shown(unit), width: 1, spanGaps: true, points: { show: false } });
      data.push(spread(curve, curve.chart.min));
      bands.push({ series: [series.length - 2, series.length - 1], fill: `${stroke}55` });
    }
  });
  const axis = { stroke: text, grid: { stroke: line, width: 1 }, ticks: { stroke: line } };
  const width = () => Math.max(240, box.clientWidth);
  const plot = new uPlot(/** @type {any} */ ({
    title, width: width(), height: 230, series, bands, legend: { show: curves.length < 9 },
    axes: [{ ...axis, values: log.time ? powers : ticks, label: "time / s", labelSize: 20, stroke: text }, { ...axis, size: 62, values: log.value ? powers : ticks }],
    scales: { x: { time: false, distr: log.time ? 3 : 1 }, y: { distr: log.value ? 3 : 1 } },
    cursor: { sync: { key: "charts" } },
  }), /** @type {any} */ (data), box);
  box.setAttribute("role", "img");
  box.setAttribute("aria-label", `${title} over time${log.time || log.value ? ", logarithmic" : ""}`);
  const missing = log.value && curves.some((curve) => curve.chart.max.some((value) => value !== null && value <= 0));
  if (missing) box.append(el("div", { class: "small quiet" }, "Values that are not positive are left out."));
  const watch = new ResizeObserver(() => plot.setSize({ width: width(), height: 230 }));
  watch.observe(box);
  return () => { watch.disconnect(); plot.destroy(); };
}

/**
 * Draws points over numbers, with bars of errors, into a box. Returns what removes them.
 * @param {HTMLElement} box
 * @param {string} across
 * @param {string} up
 * @param {{label: string, points: {x: number, y: number, error: number}[]}[]} series
 * @returns {() => void}
 */
export function scatter(box, across, up, series) {
  const style = getComputedStyle(document.documentElement);
  const [text, line] = ["--quiet", "--line"].map((name) => style.getPropertyValue(name).trim());
  const places = [...new Set(series.flatMap((one) => one.points.map((point) => point.x)))].sort((a, b) => a - b);
  const data = [places, ...series.map((one) => places.map((x) => one.points.find((point) => point.x === x)?.y ?? null))];
  const axis = { stroke: text, grid: { stroke: line, width: 1 }, ticks: { stroke: line } };
  const width = () => Math.max(240, box.clientWidth);
  const lines = series.map((one, k) => ({ label: one.label, stroke: COLOURS[k % COLOURS.length], width: 1.4, spanGaps: true, points: { show: true, size: 8, fill: COLOURS[k % COLOURS.length] } }));
  /** Standard errors, in the colours of their points. @param {any} plot */
  const bars = (plot) => {
    series.forEach((one, k) => {
      plot.ctx.save();
      plot.ctx.strokeStyle = COLOURS[k % COLOURS.length];
      plot.ctx.lineWidth = devicePixelRatio;
      for (const { x, y, error } of one.points) {
        if (!(error > 0)) continue;
        const at = plot.valToPos(x, "x", true);
        plot.ctx.beginPath();
        plot.ctx.moveTo(at, plot.valToPos(y - error, "y", true));
        plot.ctx.lineTo(at, plot.valToPos(y + error, "y", true));
        plot.ctx.stroke();
      }
      plot.ctx.restore();
    });
  };
  // Points at the edge are shown whole, and so are bars of errors.
  /** @param {any} _ @param {number} least @param {number} most @returns {[number, number]} */
  const room = (_, least, most) => { const more = 0.06 * (most - least) || Math.abs(most) * 0.1 || 1; return [least - more, most + more]; };
  /** @param {any} _ @param {number} least @param {number} most @returns {[number, number]} */
  const high = (_, least, most) => room(_, Math.min(least, ...series.flatMap((one) => one.points.map(({ y, error }) => y - error))), Math.max(most, ...series.flatMap((one) => one.points.map(({ y, error }) => y + error))));
  const plot = new uPlot(/** @type {any} */ ({
    width: width(), height: 300, series: [{ label: across }, ...lines], legend: { show: series.length > 1 && series.length < 12 },
    axes: [{ ...axis, values: ticks, label: across, labelSize: 22, stroke: text }, { ...axis, values: ticks, label: up, labelSize: 22, size: 66, stroke: text }],
    scales: { x: { time: false, range: room }, y: { range: high } }, hooks: { draw: [bars] },
  }), /** @type {any} */ (data), box);
  box.setAttribute("role", "img");
  box.setAttribute("aria-label", `${up} over ${across}`);
  const watch = new ResizeObserver(() => plot.setSize({ width: width(), height: 300 }));
  watch.observe(box);
  return () => { watch.disconnect(); plot.destroy(); };
}

/** An empty box for a chart. */
export const box = () => el("div", { class: "chart" });
