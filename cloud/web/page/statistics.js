// Results with their errors, and points of a plot of a study: one for all runs that differ in the seed alone.

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
 * Points of a result over a key; a series for each combination of the other keys. Runs that differ in the seed alone are one
 * point, their mean with its standard error; the error of a single run is that of its own rows, where it has one.
 * @param {{keys: string[], rows: {values: (string | null)[], results: (number | null)[], errors: (number | null)[]}[]}} table
 * @param {number} key index of the key across
 * @param {number} result index of the result
 * @returns {{label: string, points: {x: number, y: number, error: number}[]}[]}
 */
export function points(table, key, result) {
  const seed = table.keys.indexOf("seed");
  const others = table.keys.map((_, k) => k).filter((k) => k !== key && k !== seed);
  /** @type {Map<string, Map<number, {y: number, error: number}[]>>} */
  const series = new Map();
  for (const row of table.rows) {
    const [x, y] = [numeric(row.values[key]), row.results[result]];
    if (x === null || y == null) continue;
    const label = others.map((k) => `${table.keys[k].split(".").pop()} ${row.values[k] ?? "–"}`).join(", ");
    const at = series.get(label) ?? new Map();
    series.set(label, at);
    at.set(x, [...(at.get(x) ?? []), { y, error: row.errors[result] ?? 0 }]);
  }
  return [...series].map(([label, at]) => ({
    label: label || "result",
    points: [...at].sort(([a], [b]) => a - b).map(([x, runs]) => {
      if (runs.length === 1) return { x, ...runs[0] };
      const values = runs.map((run) => run.y);
      const mean = values.reduce((sum, value) => sum + value, 0) / values.length;
      const variance = values.reduce((sum, value) => sum + (value - mean) ** 2, 0) / (values.length - 1);
      return { x, y: mean, error: Math.sqrt(variance / values.length) };
    }),
  }));
}
