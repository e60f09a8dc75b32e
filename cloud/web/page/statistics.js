// Points of a plot of a study: one for all runs that differ in the seed alone.

/** A number of a value of TOML, or null. @param {string | null | undefined} text */
export const numeric = (text) => (text != null && /^[-+0-9.eE_]+$/.test(text.trim()) && Number.isFinite(Number(text.replaceAll("_", ""))) ? Number(text.replaceAll("_", "")) : null);

/**
 * Points of a result over a key; a series for each combination of the other keys. Runs that differ in the seed alone are one
 * point, their mean with its standard error.
 * @param {{keys: string[], rows: {values: (string | null)[], results: (number | null)[]}[]}} table
 * @param {number} key index of the key across
 * @param {number} result index of the result
 * @returns {{label: string, points: {x: number, y: number, error: number}[]}[]}
 */
export function points(table, key, result) {
  const seed = table.keys.indexOf("seed");
  const others = table.keys.map((_, k) => k).filter((k) => k !== key && k !== seed);
  /** @type {Map<string, Map<number, number[]>>} */
  const series = new Map();
  for (const row of table.rows) {
    const [x, y] = [numeric(row.values[key]), row.results[result]];
    if (x === null || y == null) continue;
    const label = others.map((k) => `${table.keys[k].split(".").pop()} ${row.values[k] ?? "–"}`).join(", ");
    const at = series.get(label) ?? new Map();
    series.set(label, at);
    at.set(x, [...(at.get(x) ?? []), y]);
  }
  return [...series].map(([label, at]) => ({
    label: label || "result",
    points: [...at].sort(([a], [b]) => a - b).map(([x, values]) => {
      const mean = values.reduce((sum, value) => sum + value, 0) / values.length;
      const variance = values.length > 1 ? values.reduce((sum, value) => sum + (value - mean) ** 2, 0) / (values.length - 1) : 0;
      return { x, y: mean, error: Math.sqrt(variance / values.length) };
    }),
  }));
}
