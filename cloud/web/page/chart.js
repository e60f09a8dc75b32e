// Charts of table columns over time; uPlot draws, the server has reduced them.
import { el } from "./dom.js";
import uPlot from "./vendor/uPlot.esm.js";

const COLOURS = ["#2f7fb8", "#d98a2b", "#3c9a67", "#c0504d", "#8064a2", "#6b8e23", "#008b8b", "#b8860b"];

/** @typedef {{label: string, chart: {time: number[], min: (number | null)[], max: (number | null)[]}}} Curve */

/**
 * Draws curves over each other into a box. Returns what removes them.
 * @param {HTMLElement} box
 * @param {string} title
 * @param {Curve[]} curves
 * @returns {() => void}
 */
export function draw(box, title, curves) {
  const style = getComputedStyle(document.documentElement);
  const [text, line] = ["--quiet", "--line"].map((name) => style.getPropertyValue(name).trim());
  const times = [...new Set(curves.flatMap((curve) => curve.chart.time))].sort((a, b) => a - b);
  const at = new Map(times.map((time, k) => [time, k]));
  /** @param {Curve} curve @param {(number | null)[]} values */
  const spread = (curve, values) => {
    const all = new Array(times.length).fill(undefined);
    curve.chart.time.forEach((time, k) => { all[/** @type {number} */ (at.get(time))] = values[k]; });
    return all;
  };
  // Where bins have more than one row, the band from least to largest is the curve.
  const banded = curves.some((curve) => curve.chart.min.some((value, k) => value !== curve.chart.max[k]));
  const series = /** @type {any[]} */ ([{ label: "time / s" }]);
  const data = [times];
  const bands = /** @type {any[]} */ ([]);
  curves.forEach((curve, k) => {
    const stroke = COLOURS[k % COLOURS.length];
    series.push({ label: curve.label, stroke, width: 1.6, spanGaps: true, points: { show: curve.chart.time.length < 30 } });
    data.push(spread(curve, curve.chart.max));
    if (banded) {
      series.push({ label: `${curve.label} least`, stroke, width: 1, spanGaps: true, points: { show: false } });
      data.push(spread(curve, curve.chart.min));
      bands.push({ series: [series.length - 2, series.length - 1], fill: `${stroke}55` });
    }
  });
  const axis = { stroke: text, grid: { stroke: line, width: 1 }, ticks: { stroke: line } };
  const width = () => Math.max(240, box.clientWidth);
  /** Few digits where few tell values apart. @param {any} _ @param {number[]} values */
  const ticks = (_, values) => values.map((value) => (value === 0 ? "0" : Math.abs(value) >= 1e5 || Math.abs(value) < 1e-3 ? value.toExponential(1).replace("e+", "e") : String(Number(value.toPrecision(4)))));
  const plot = new uPlot(/** @type {any} */ ({
    title, width: width(), height: 230, series, bands, legend: { show: curves.length > 1 && curves.length < 9 },
    axes: [{ ...axis, values: ticks, label: "time / s", labelSize: 20, stroke: text }, { ...axis, size: 62, values: ticks }], scales: { x: { time: false } },
    cursor: { sync: { key: "charts" } },
  }), /** @type {any} */ (data), box);
  box.setAttribute("role", "img");
  box.setAttribute("aria-label", `${title} over time`);
  const watch = new ResizeObserver(() => plot.setSize({ width: width(), height: 230 }));
  watch.observe(box);
  return () => { watch.disconnect(); plot.destroy(); };
}

/** An empty box for a chart. */
export const box = () => el("div", { class: "chart" });
