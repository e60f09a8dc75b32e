// Results with their errors, looks at results that end a run, and points of a plot of a study: one for all runs that differ in the seed alone.
import { cells } from "./preview.js";

/** A number of a value of TOML, or null. @param {string | null | undefined} text */
export const numeric = (text) => (text != null && /^[-+0-9.eE_]+$/.test(text.trim()) && Number.isFinite(Number(text.replaceAll("_", ""))) ? Number(text.replaceAll("_", "")) : null);

/**
 * A value with its standard error, to two digits of the error: `12.30 ± 0.45`, `(-6.47 ± 0.49)e-4`.
 * @param {number} value
 * @param {number} error
 */
export function uncertain(value, error) {
  if (!(error > 0) || !Number.isFinite(error)) return String(Number(value.toPrecision(5)));
  const size = Math.max(Math.abs(value), error);
  // The exponent that both are written with, where plain digits are long.
  const exponent = size >= 1e5 || size < 1e-2 ? Math.floor(Math.log10(size)) : 0;
  const scale = 10 ** exponent;
  // What is rounded up to the next power of ten has a digit less behind the point.
  const digits = Number((error / scale).toPrecision(2));
  const decimals = Math.min(12, Math.max(0, 1 - Math.floor(Math.log10(digits) + 1e-9)));
  const both = `${(value / scale).toFixed(decimals)} ± ${digits.toFixed(decimals)}`;
  return exponent ? `(${both})e${exponent}` : both;
}

/**
 * Points of a result over a key; a series for each combination of the other keys. Where runs differ in their seed, a point is the mean
 * of its seeds with its error; the error of a single run is that of its own rows, where it has one.
 * @param {{keys: string[], rows: {values: (string | null)[], results: (number | null)[], errors: (number | null)[]}[], means: {values: (string | null)[], results: any[]}[]}} table
 * @param {number} key index of the key across
 * @param {number} result index of the result
 * @returns {{label: string, points: {x: number, y: number, error: number}[]}[]}
 */
export function points(table, key, result) {
  const seed = table.keys.indexOf("seed");
  const means = key !== seed && table.means.length > 0;
  const others = table.keys.map((_, k) => k).filter((k) => k !== key && k !== seed);
  /** The values of a point lack the seed. @param {{values: (string | null)[]}} row @param {number} k */
  const value = (row, k) => row.values[means && k > seed ? k - 1 : k];
  /** @type {Map<string, {x: number, y: number, error: number}[]>} */
  const series = new Map();
  for (const row of means ? table.means : table.rows) {
    const found = row.results[result];
    const [y, error] = means ? [found.mean, found.error ?? found.within] : [found, /** @type {any} */ (row).errors[result]];
    const x = numeric(value(row, key));
    if (x === null || y == null) continue;
    const label = others.map((k) => `${table.keys[k].split(".").pop()} ${value(row, k) ?? "–"}`).join(", ") || "result";
    series.set(label, [...(series.get(label) ?? []), { x, y, error: error ?? 0 }]);
  }
  return [...series].map(([label, at]) => ({ label, points: at.sort((a, b) => a.x - b.x) }));
}

/**
 * A result of `time.until` at each look: value, ends of its 95 % interval, and of the last look the errors and the missing time.
 * @typedef {{name: string, unit: string, time: number[], value: number[], low: number[], high: number[], error: number, wanted: number, steady: boolean, more: number}} Looks
 */

/**
 * Reads the table `results.csv` of a run.
 * @param {string} text
 * @returns {Looks[]}
 */
export function looks(text) {
  // The last line may be cut.
  const [head, ...lines] = text.slice(0, text.lastIndexOf("\n") + 1).split("\n").filter((line) => line && !line.startsWith("#")).map(cells);
  /** @type {Map<string, Looks>} */
  const found = new Map();
  const at = (/** @type {string} */ column) => head.findIndex((cell) => cell.replace(/ \[.*/, "") === column);
  for (const line of lines) {
    const number = (/** @type {string} */ column) => Number(line[at(column)]);
    const name = line[at("name")];
    const one = found.get(name) ?? { name, unit: line[at("unit")], time: [], value: [], low: [], high: [], error: 0, wanted: 0, steady: false, more: 0 };
    for (const column of /** @type {const} */ (["time", "value", "low", "high"])) one[column].push(number(column));
    found.set(name, Object.assign(one, { error: number("error"), wanted: number("wanted"), steady: number("steady") === 1, more: number("more") }));
  }
  return [...found.values()];
}

/**
 * Seconds by the clock until all results are known, where that is before the end of the run: the missing time grows smaller as the run goes on.
 * @param {{time: number, step: number, of_steps?: number | null, seconds_left?: number | null}} run
 * @param {Looks[]} all
 * @returns {number | null}
 */
export function known(run, all) {
  if (!all.length || !run.of_steps || !run.step || run.seconds_left == null) return null;
  const rest = (run.time * (run.of_steps - run.step)) / run.step;
  const more = Math.max(...all.map((one) => one.more - (run.time - one.time[one.time.length - 1])));
  return more < rest && rest > 0 ? (run.seconds_left * Math.max(0, more)) / rest : null;
}
