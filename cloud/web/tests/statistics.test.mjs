// node --test web/tests/
import assert from "node:assert/strict";
import { test } from "node:test";
import { numeric, points, uncertain } from "../page/statistics.js";

test("values of TOML that are numbers", () => {
  for (const [text, value] of [["1", 1], ["-2.5e-3", -2.5e-3], ["1_000", 1000], [" 3 ", 3], ["0", 0]]) assert.equal(numeric(text), value);
  for (const text of [null, undefined, "", "a", "\"1\"", "[1]", "true", "e", "."]) assert.equal(numeric(text), null);
});

test("runs that differ in the seed alone are one point with its standard error", () => {
  const row = (...values) => ({ values: values.slice(0, -1), results: [values.at(-1)], errors: [values.at(-1) === 4 ? 0.25 : null] });
  const table = { keys: ["a.friction", "seed", "b.size"], rows: [
    row("0.2", "1", "3", 4), row("0.1", "1", "3", 1), row("0.1", "2", "3", 2), row("0.1", "3", "3", 3), row("0.1", "1", "5", 7),
    row("0.3", "1", "3", null), row(null, "1", "3", 9), row("soft", "1", "3", 9)] };
  const series = points(table, 0, 0);
  assert.deepEqual(series.map((one) => one.label), ["size 3", "size 5"]);
  // The mean of 1, 2, 3 is 2; their standard deviation 1, over the root of 3.
  assert.deepEqual(series[0].points.map(({ x, y }) => [x, y]), [[0.1, 2], [0.2, 4]]);
  assert.ok(Math.abs(series[0].points[0].error - 1 / Math.sqrt(3)) < 1e-15);
  // One run has the error of its own rows, and none where the solver gives none.
  assert.equal(series[0].points[1].error, 0.25);
  assert.equal(series[1].points[0].error, 0);
  // The seed itself can be across.
  assert.equal(points({ keys: ["seed"], rows: [row("1", 5), row("2", 6)] }, 0, 0)[0].points.length, 2);
});

test("values with errors have two digits of the error", () => {
  for (const [value, error, text] of [[12.3, 0.45, "12.30 ± 0.45"], [-6.4735e-4, 4.921e-5, "(-6.47 ± 0.49)e-4"], [3, 120, "3 ± 120"], [12345.6, 98.7, "12346 ± 99"], [2.5e7, 3.1e6, "(2.50 ± 0.31)e7"],
    [1, 0.0996, "1.00 ± 0.10"], [0, 0.5, "0.00 ± 0.50"], [0.1234567, 0, "0.12346"], [5, NaN, "5"]]) assert.equal(uncertain(value, error), text);
});
