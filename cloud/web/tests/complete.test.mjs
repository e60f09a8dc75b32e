// node --test web/tests/
import assert from "node:assert/strict";
import { test } from "node:test";
import { complete, context } from "../page/complete.js";

/** Context at the mark `|` in a text. */
const at = (marked) => context(marked.replace("|", ""), marked.indexOf("|"));

test("the place of a caret in a scene", () => {
  const cases = [
    ["ti|", "key", [], "", "ti"],
    ["[time]\nen|", "key", ["time"], "", "en"],
    ["[time]\nend = 1\n|", "key", ["time"], "", ""],
    ["[time]\nstep = \"au|\"\n", "value", ["time"], "step", "\"au"],
    ["[[walls]]\nname = \"a # b\"\nsh| = \"plane\"", "key", ["walls"], "", "sh"],
    ["[materials.glass]\nnormal = { law = \"linear\", stif|", "key", ["materials", "glass", "normal"], "", "stif"],
    ["[materials.glass]\nnormal = { law = |", "value", ["materials", "glass", "normal"], "law", ""],
    ["[[walls]]\nmotion = [{ kind = \"rotation\", ax|", "key", ["walls", "motion"], "", "ax"],
    ["[[walls]]\nmotion = [\n  { kind = \"rotation\" },\n  { ki|", "key", ["walls", "motion"], "", "ki"],
    ["[wa|", "head", [], "", "wa"],
    ["[materials.|", "head", ["materials"], "", ""],
    ["time.en|", "key", ["time"], "", "en"],
    ["a = 1 # com|ment", "none", [], "", ""],
    ["a = '''\n[time]\n'''\nb|", "key", null, "", "b"],
    ["[time]\nend = 1 # s\nst|\n[domain]\nmin = 1", "key", ["time"], "", "st"],
  ];
  for (const [marked, kind, path, key, word] of cases) {
    const found = at(marked);
    assert.equal(found.kind, kind, marked);
    if (path) assert.deepEqual(found.path, path, marked);
    assert.equal(found.key, key, marked);
    assert.equal(found.word, word, marked);
  }
  // Keys before and behind the caret are those of the same table.
  assert.deepEqual(at("[a]\nx = 1\n[[walls]]\nname = \"w\"\n|\nshape = \"plane\"\n[b]\ny = 1").keys, { name: "w", shape: "plane" });
  assert.deepEqual(at("m = { law = \"linear\", |, e = 2 }").keys, { law: "linear", e: "2" });
});

const schema = {
  properties: { time: { $ref: "#/$defs/time", description: "duration" }, walls: { type: "array", items: { $ref: "#/$defs/walls" } }, materials: { type: "object", additionalProperties: { properties: { density: { type: "number", description: "in kg/m3" } } } }, seed: { type: "integer" } },
  $defs: {
    time: { type: "object", properties: { end: { type: "number", description: "simulated time; in s" }, step: { anyOf: [{ type: "number" }, { const: "auto" }] }, rest: { type: "boolean" } } },
    walls: { oneOf: [{ properties: { shape: { const: "plane" }, material: { type: "string" }, normal: { type: "array", items: { type: "number" } } } }, { properties: { shape: { const: "cylinder", description: "round" }, material: { type: "string" }, radius: { type: "number" } } }] },
  },
};
const texts = (marked) => complete(schema, marked.replace("|", ""), marked.indexOf("|")).candidates.map((one) => one.text);
const help = (marked) => complete(schema, marked.replace("|", ""), marked.indexOf("|")).help;

test("keys, values and tables that can stand at the caret", () => {
  assert.deepEqual(texts("[time]\n|"), ["end", "step", "rest"]);
  assert.deepEqual(texts("[time]\nend = 1\ns|"), ["step"]);
  assert.deepEqual(texts("[time]\nstep = |"), ["\"auto\""]);
  assert.deepEqual(texts("[time]\nrest = t|"), ["true"]);
  assert.deepEqual(texts("[[walls]]\nshape = |"), ["\"plane\"", "\"cylinder\""]);
  // The shape decides which keys there are; without it all are.
  assert.deepEqual(texts("[[walls]]\nshape = \"cylinder\"\n|"), ["material", "radius"]);
  assert.deepEqual(texts("[[walls]]\n|"), ["shape", "material", "normal", "radius"]);
  assert.deepEqual(texts("[materials.steel]\n[[walls]]\nmaterial = |"), ["\"steel\""]);
  assert.deepEqual(texts("[|"), ["time", "walls", "materials"]);
  assert.deepEqual(texts("[materials.glass]\nd|"), ["density"]);
  assert.deepEqual(texts("# [|"), []);
  assert.equal(help("[time]\nend| = 1"), "end: simulated time; in s");
  assert.equal(help("[time]\nend = 1|"), "end: simulated time; in s");
});
