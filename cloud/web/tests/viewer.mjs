// The viewer with 1e5 and 1e6 spheres in software rendering: seconds for a frame, and that what is drawn is there.
// viewer.mjs LINK; PICTURES=folder keeps pictures.
import { Browser } from "./browser.mjs";

const link = process.argv[2] ?? process.env.MERCURY_CLOUD_LINK;
const browser = await Browser.start();
try {
  await browser.look(1024, 768, false);
  await browser.open(link);
  await browser.until(`document.querySelector("tbody")`, "not logged in");
  const frame = (count) => `(async () => {
    const { Viewer } = await import("/viewer.js");
    const box = document.createElement("div");
    document.body.replaceChildren(box);
    const viewer = new Viewer(box, { height: "760px" });
    // A cube of spheres that fill half of it.
    const n = ${count}, radius = Math.cbrt(0.5 / n * 3 / (4 * Math.PI));
    const column = (make) => ({ values: Float32Array.from({ length: n }, make) });
    let seed = 1;
    const next = () => (seed = (seed * 16807) % 2147483647) / 2147483647;
    const columns = { x: column(next), y: column(next), z: column(next), radius: column(() => radius) };
    const begin = performance.now();
    viewer.frame({ rows: n, ids: Uint32Array.from({ length: n }, (_, k) => k), columns }, columns.z.values, [0, 1], "z / m", [[0, 0, 0], [1, 1, 1]]);
    cancelAnimationFrame(viewer.due);
    viewer.due = 0;
    viewer.paint(false);
    const first = performance.now() - begin;
    const again = performance.now();
    viewer.camera.azimuth += 0.3;
    viewer.paint(false);
    const gl = viewer.gl, pixels = new Uint8Array(4 * viewer.canvas.width * viewer.canvas.height);
    const next_ms = performance.now() - again;
    gl.readPixels(0, 0, viewer.canvas.width, viewer.canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    let covered = 0;
    for (let k = 3; k < pixels.length; k += 4) covered += pixels[k] > 0 ? 1 : 0;
    return [first, next_ms, covered / (pixels.length / 4)];
  })()`;
  for (const [count, most] of [[1e5, 1000], [1e6, 10000]]) {
    const [first, next, covered] = await browser.run(frame(count));
    console.log(`${count} spheres: first picture ${first.toFixed(0)} ms, next ${next.toFixed(0)} ms, ${(100 * covered).toFixed(0)} % of the pixels covered`);
    // A cube seen from its side covers between a tenth and nine tenths of the picture.
    if (covered < 0.1 || covered > 0.9) throw new Error("nothing, or not a cube, was drawn");
    if (next > most) console.log(`  slower than ${most} ms on this machine`);
    await browser.picture(`spheres-${count}.png`);
  }
  if (browser.complaints.length) throw new Error(browser.complaints.join("\n"));
} finally {
  await browser.stop();
}
