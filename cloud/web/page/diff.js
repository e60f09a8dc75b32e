// Differences of two texts, line by line.

/** The most lines of a text that are compared. */
const MOST = 3000;

/**
 * The lines of two texts: those of both (` `), of the first one (`-`), of the second one (`+`), by a longest common subsequence.
 * @param {string} a
 * @param {string} b
 * @returns {[string, string][]}
 */
export function lines(a, b) {
  const [x, y] = [a, b].map((text) => text.trimEnd().split("\n").slice(0, MOST));
  // What is the same at the begin and at the end needs no table.
  let begin = 0;
  while (begin < x.length && begin < y.length && x[begin] === y[begin]) begin += 1;
  let end = 0;
  while (end < x.length - begin && end < y.length - begin && x[x.length - 1 - end] === y[y.length - 1 - end]) end += 1;
  const [p, q] = [x.slice(begin, x.length - end), y.slice(begin, y.length - end)];
  const width = q.length + 1;
  const common = new Uint16Array((p.length + 1) * width);
  for (let i = p.length - 1; i >= 0; i -= 1) {
    for (let j = q.length - 1; j >= 0; j -= 1) {
      common[i * width + j] = p[i] === q[j] ? common[(i + 1) * width + j + 1] + 1 : Math.max(common[(i + 1) * width + j], common[i * width + j + 1]);
    }
  }
  const found = /** @type {[string, string][]} */ (x.slice(0, begin).map((line) => [" ", line]));
  let [i, j] = [0, 0];
  while (i < p.length || j < q.length) {
    if (i < p.length && j < q.length && p[i] === q[j]) { found.push([" ", p[i]]); i += 1; j += 1; }
    else if (j === q.length || (i < p.length && common[(i + 1) * width + j] >= common[i * width + j + 1])) { found.push(["-", p[i]]); i += 1; }
    else { found.push(["+", q[j]]); j += 1; }
  }
  return [...found, ...x.slice(x.length - end).map((line) => /** @type {[string, string]} */ ([" ", line]))];
}

/**
 * The lines that differ, each with so many lines around it; `…` stands for what is left out.
 * @param {[string, string][]} all
 * @param {number} around
 * @returns {[string, string][]}
 */
export function differing(all, around) {
  const near = all.map((_, k) => all.slice(Math.max(0, k - around), k + around + 1).some(([mark]) => mark !== " "));
  return all.flatMap((line, k) => (near[k] ? [line] : near[k - 1] || (k === 0 && near.includes(true)) ? [/** @type {[string, string]} */ ([" ", "…"])] : []));
}
