// node --test web/tests/
import assert from "node:assert/strict";
import { test } from "node:test";
import { axes, distanceToSee, scaleBar } from "../page/camera.js";
import { cells } from "../page/preview.js";

test("the view at the beginning shows all corners of the domain, whatever its shape and that of the view", () => {
  const dot = (a, b) => a.reduce((sum, x, k) => sum + x * b[k], 0);
  const { back, right, up } = axes({ azimuth: -1.05, elevation: 0.28 });
  for (const [x, y, z] of [[1, 1, 1], [0.01, 3, 0.2], [5, 0.1, 0.1], [0.1, 0.1, 4], [1, 1, 0]]) {
    for (const aspect of [0.4, 1, 2.5]) {
      const distance = distanceToSee([[0, 0, 0], [x, y, z]], aspect);
      let most = 0;
      for (let k = 0; k < 8; k += 1) {
        const corner = [x, y, z].map((length, c) => ((k >> c) & 1 ? 0.5 : -0.5) * length);
        const depth = distance - dot(corner, back);
        assert.ok(depth > 0);
        // Half of the view is 1 wide and high.
        most = Math.max(most, Math.abs(dot(corner, right)) / (Math.tan(0.3) * aspect * depth), Math.abs(dot(corner, up)) / (Math.tan(0.3) * depth));
      }
      assert.ok(most <= 1, `${[x, y, z]} at ${aspect}: ${most}`);
      // Not smaller than needed either.
      assert.ok(most > 0.85, `${[x, y, z]} at ${aspect}: ${most}`);
    }
  }
});

test("a scale bar has a round length that fits", () => {
  for (const [density, most, label, pixels] of [[1000, 140, "100 mm", 100], [1000, 260, "200 mm", 200], [70, 140, "2 m", 140], [5e5, 140, "200 µm", 100], [0.02, 140, "5 km", 100]]) {
    const bar = scaleBar(density, most);
    assert.equal(bar.label, label);
    assert.ok(Math.abs(bar.pixels - pixels) < 1e-9 * pixels);
  }
});

test("cells of tables", () => {
  assert.deepEqual(cells("0.5,\"in, left\",,\"a \"\"b\"\"\""), ["0.5", "in, left", "", "a \"b\""]);
  assert.deepEqual(cells(" 1  2.5 x"), ["1", "2.5", "x"]);
  assert.deepEqual(cells(",a"), ["", "a"]);
});
