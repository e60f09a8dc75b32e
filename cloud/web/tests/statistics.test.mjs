// node --test web/tests/
import assert from "node:assert/strict";
import { test } from "node:test";
import { numeric, points } from "../page/statistics.js";

test("values of TOML that are numbers", () => {
  for (const [text, value] of [["1", 1], ["-2.5e-3", -2.5e-3], ["1_000", 1000], [" 3 ", 3], ["0", 0]]) assert.equal(numeric(text), value);
  for (const text of [null, undefined, "", "a", "\"1\"", "[1]", "true", "e", "."]) assert.equal(numeric(text), null);
});

test("runs that differ in the seed alone are one point with its standard error", () => {
  const row = (...values) => ({ values: values.slice(0, -1), results: [values.at(-1)] });
  const table = { keys: ["a.friction", "seed", "b.size"], rows: [
    row("0.2", "1", "3", 4), row("0.1", "1", "3", 1), row("0.1", "2", "3", 2), row("0.1", "3", "3", 3), row("0.1", "1", "5", 7),
    row("0.3", "1", "3", null), row(null, "1", "3", 9), row("soft", "1", "3", 9)] };
  const series = points(table, 0, 0);
  assert.deepEqual(series.map((one) => one.label), ["size 3", "size 5"]);
  // The mean of 1, 2, 3 is 2; their standard deviation 1, over the root of 3.
  assert.deepEqual(series[0].points.map(({ x, y }) => [x, y]), [[0.1, 2], [0.2, 4]]);
  assert.ok(Math.abs(series[0].points[0].error - 1 / Math.sqrt(3)) < 1e-15);
  assert.equal(series[0].points[1].error, 0);
  // The seed itself can be across.
  assert.equal(points({ keys: ["seed"], rows: [row("1", 5), row("2", 6)] }, 0, 0)[0].points.length, 2);
});
