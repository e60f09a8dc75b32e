// node --test web/tests/
import assert from "node:assert/strict";
import { test } from "node:test";
import { known, looks, numeric, points, uncertain } from "../page/statistics.js";

test("values of TOML that are numbers", () => {
  for (const [text, value] of [["1", 1], ["-2.5e-3", -2.5e-3], ["1_000", 1000], [" 3 ", 3], ["0", 0]]) assert.equal(numeric(text), value);
  for (const text of [null, undefined, "", "a", "\"1\"", "[1]", "true", "e", "."]) assert.equal(numeric(text), null);
});

test("runs that differ in the seed alone are one point, their mean with its error", () => {
  const row = (...values) => ({ values: values.slice(0, -1), results: [values.at(-1)], errors: [values.at(-1) === 4 ? 0.25 : null] });
  const mean = (friction, size, mean, error, within = null) => ({ values: [friction, size], results: [{ mean, error, within }] });
  const table = { keys: ["a.friction", "seed", "b.size"], rows: [row("0.1", "1", "3", 1), row("0.1", "2", "3", 2)], means: [
    mean("0.2", "3", 4, null, 0.25), mean("0.1", "3", 2, 0.5), mean("0.1", "5", 7, null), mean("0.3", "3", null, null), mean(null, "3", 9, 1), mean("soft", "3", 9, 1)] };
  const series = points(table, 0, 0);
  assert.deepEqual(series, [{ label: "size 3", points: [{ x: 0.1, y: 2, error: 0.5 }, { x: 0.2, y: 4, error: 0.25 }] }, { label: "size 5", points: [{ x: 0.1, y: 7, error: 0 }] }]);
  // Without means each run is a point, with the error of its own rows.
  const single = points({ keys: ["a.friction"], rows: [row("0.2", 4), row("0.1", 1), row(null, 9), row("0.3", null)], means: [] }, 0, 0);
  assert.deepEqual(single, [{ label: "result", points: [{ x: 0.1, y: 1, error: 0 }, { x: 0.2, y: 4, error: 0.25 }] }]);
  // The seed itself can be across.
  assert.equal(points({ keys: ["seed"], rows: [row("1", 5), row("2", 6)], means: [mean(null, null, 5.5, 1)] }, 0, 0)[0].points.length, 2);
});

test("values with errors have two digits of the error", () => {
  for (const [value, error, text] of [[12.3, 0.45, "12.30 ± 0.45"], [-6.4735e-4, 4.921e-5, "(-6.47 ± 0.49)e-4"], [3, 120, "3 ± 120"], [12345.6, 98.7, "12346 ± 99"], [2.5e7, 3.1e6, "(2.50 ± 0.31)e7"],
    [1, 0.0996, "1.00 ± 0.10"], [0, 0.5, "0.00 ± 0.50"], [0.1234567, 0, "0.12346"], [5, NaN, "5"]]) assert.equal(uncertain(value, error), text);
});

test("looks at results that end a run, and the time until they are known", () => {
  const text = "time [s],name,unit,value,error,low,high,wanted,batches,from [s],to [s],steady,more [s]\n1,\"a,b\",N,5,0.5,4,6,0.1,8,0.2,1,0,3\n1,c,1,2,0.2,1,3,0.4,8,0.2,1,1,0\n1.5,\"a,b\",N,5.5,0.25,5,6,0.1,8,0.2,1.5,1,2\n2,c,1,2";
  const [first, second, ...none] = looks(text);
  assert.deepEqual(none, []);
  assert.deepEqual(first, { name: "a,b", unit: "N", time: [1, 1.5], value: [5, 5.5], low: [4, 5], high: [6, 6], error: 0.25, wanted: 0.1, steady: true, more: 2 });
  assert.deepEqual([second.name, second.time, second.more], ["c", [1], 0]);
  assert.deepEqual(looks(""), []);
  // At 2 s of 10 s, with 80 s left: 1.5 s of simulated time are missing still, 15 s by the clock.
  const run = { time: 2, step: 200, of_steps: 1000, seconds_left: 80 };
  assert.ok(Math.abs(known(run, looks(text)) - 15) < 1e-12);
  // The end comes first, nothing is known, or nothing is missing any more.
  assert.equal(known({ ...run, of_steps: 300 }, looks(text)), null);
  assert.equal(known({ ...run, seconds_left: null }, looks(text)), null);
  assert.equal(known(run, []), null);
  assert.equal(known({ ...run, time: 4, step: 400 }, looks(text)), 0);
});
