import assert from "node:assert/strict";
import test from "node:test";
import { differing, lines } from "../page/diff.js";

test("lines of both, of the first and of the second text", () => {
  assert.deepEqual(lines("a\nb\nc\nd\n", "a\nx\nc\nd\ne\n"), [[" ", "a"], ["-", "b"], ["+", "x"], [" ", "c"], [" ", "d"], ["+", "e"]]);
  assert.deepEqual(lines("a\nb", "a\nb"), [[" ", "a"], [" ", "b"]]);
  // The first text is what is not added, the second what is not removed.
  const [a, b] = ["1\n2\n3\n4\n5\n6", "0\n2\n4\n3\n5\n7\n6"];
  const found = lines(a, b);
  const of = (mark) => found.filter(([one]) => one !== mark).map(([, line]) => line).join("\n");
  assert.equal(of("+"), a);
  assert.equal(of("-"), b);
});

test("lines around those that differ", () => {
  const all = lines("1\n2\n3\n4\n5\n6\n7", "1\n2\n3\nx\n5\n6\n7");
  assert.deepEqual(differing(all, 1), [[" ", "…"], [" ", "3"], ["-", "4"], ["+", "x"], [" ", "5"], [" ", "…"]]);
  assert.deepEqual(differing(lines("1", "1"), 1), []);
});
