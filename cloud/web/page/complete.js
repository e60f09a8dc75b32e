// Keys of a scene where the caret stands, from the schema of scenes: what can stand there, and what a key means.

/** @typedef {Record<string, any>} Schema */
/** @typedef {{text: string, help: string}} Candidate */
/** @typedef {{list: boolean, path: string[], keys: Record<string, string>}} Frame */

/** Parts of a dotted key: `a."b.c".d`. @param {string} text */
const parts = (text) => [...text.matchAll(/"([^"]*)"|'([^']*)'|([A-Za-z0-9_-]+)/g)].map((found) => found[1] ?? found[2] ?? found[3]);

/** A value of TOML as text, without quotes. @param {string} text */
const plain = (text) => text.trim().replace(/^["'](.*)["']$/, "$1");

/**
 * Where a caret stands in a text of TOML: in a key, a value or the head of a table. `path` leads to the table, `word` has been typed of
 * the key or value, `from` is its first character, `keys` are the keys of the same table with their values.
 * @param {string} text
 * @param {number} caret
 * @returns {{kind: "key" | "value" | "head" | "none", path: string[], key: string, word: string, from: number, keys: Record<string, string>}}
 */
export function context(text, caret) {
  const none = { kind: /** @type {"none"} */ ("none"), path: [], key: "", word: "", from: caret, keys: {} };
  // Texts of several lines count as texts of one line.
  text = text.replace(/('''|""")[\s\S]*?\1/g, (long) => `"${" ".repeat(long.length - 2)}"`);
  // Heads of tables: each is a line of its own.
  const heads = [...text.matchAll(/^[ \t]*\[\[?[ \t]*([A-Za-z0-9_"'. -]+?)[ \t]*\]\]?[ \t]*(?:#.*)?$/gm)];
  const begun = text.slice(text.lastIndexOf("\n", caret - 1) + 1, caret).match(/^[ \t]*\[\[?[ \t]*([A-Za-z0-9_"'.-]*)$/);
  if (begun) {
    const above = begun[1].split(".");
    const word = above.pop() ?? "";
    return { kind: "head", path: parts(above.join(".")), key: "", word, from: caret - word.length, keys: {} };
  }
  const head = heads.filter((one) => one.index + one[0].length < caret).at(-1);
  const next = heads.find((one) => one.index >= caret);
  const begin = head ? head.index + head[0].length : 0;
  const end = next ? next.index : text.length;

  /** @type {Frame[]} */
  const frames = [{ list: false, path: head ? parts(head[1]) : [], keys: {} }];
  let [key, value, from, at] = ["", false, begin, begin];
  /** @type {any} */
  let found = null;
  const look = () => {
    const typed = text.slice(from, caret);
    const word = typed.trimStart();
    const above = !value && !frames.at(-1)?.list ? word.split(".") : [word];
    const last = above.pop() ?? "";
    found = { kind: value || frames.at(-1)?.list ? "value" : "key", path: [...(frames.at(-1)?.path ?? []), ...parts(above.join("."))], key, word: last, from: caret - last.length, frame: frames.at(-1) };
  };
  /** Records the value that ends here. */
  const close = () => {
    const frame = frames.at(-1);
    if (value && frame && !frame.list && key) frame.keys[key] = plain(text.slice(from, at));
  };
  while (at < end) {
    if (at === caret && !found) look();
    const c = text[at];
    const frame = frames[frames.length - 1];
    if (c === "#") {
      const line = text.indexOf("\n", at);
      const stop = line < 0 ? end : line;
      // Nothing is completed in a comment.
      if (caret > at && caret <= stop) return none;
      // The line ends a value of its own; one in brackets goes on.
      if (frames.length === 1) {
        close();
        [key, value, from] = ["", false, stop + 1];
      }
      at = frames.length === 1 ? stop + 1 : stop;
      continue;
    }
    if (c === "\"" || c === "'") {
      let stop = at + 1;
      while (stop < end && text[stop] !== c && text[stop] !== "\n") stop += c === "\"" && text[stop] === "\\" ? 2 : 1;
      stop = Math.min(end, stop + (text[stop] === c ? 1 : 0));
      if (caret > at && caret < stop) look();
      at = stop;
      continue;
    }
    if (c === "=" && !value && !frame.list) { key = parts(text.slice(from, at)).join("."); [value, from] = [true, at + 1]; }
    else if (c === "{" || c === "[") {
      frames.push({ list: c === "[", path: frame.list || !key ? frame.path : [...frame.path, ...key.split(".")], keys: {} });
      // What is recorded of this value later is that it is a table or list.
      [value, from] = [c === "[", at + 1];
      frame.keys[key] = c;
      if (c === "{") key = "";
    } else if ((c === "}" || c === "]") && frames.length > 1) {
      close();
      frames.pop();
      [key, value, from] = ["", frames[frames.length - 1].list, at + 1];
    } else if (c === "," && frames.length > 1) {
      close();
      [key, value, from] = [frame.list ? key : "", frame.list, at + 1];
    } else if (c === "\n" && frames.length === 1) {
      close();
      [key, value, from] = ["", false, at + 1];
    }
    at += 1;
  }
  if (!found) look();
  const { frame, ...rest } = found;
  return { ...rest, keys: frame.keys };
}

/** Schemas without references and alternatives. @param {Schema} root @param {Schema | undefined} node @returns {Schema[]} */
function flat(root, node) {
  if (!node) return [];
  if (node.$ref) return flat(root, node.$ref.slice(2).split("/").reduce((/** @type {any} */ at, /** @type {string} */ part) => at?.[part.replaceAll("~1", "/").replaceAll("~0", "~")], root));
  const more = [...(node.oneOf ?? []), ...(node.anyOf ?? [])].flatMap((one) => flat(root, one));
  const own = node.properties || node.items || typeof node.additionalProperties === "object" || "const" in node || node.enum || (node.type && !more.length) ? [node] : [];
  return [...own, ...more];
}

/** Schemas of a table with entries, or of the entries of a list. @param {Schema} root @param {Schema[]} nodes @returns {Schema[]} */
const entries = (root, nodes) => nodes.flatMap((node) => (node.items ? entries(root, flat(root, node.items)) : [node]));

/** Schemas at the end of a path. @param {Schema} root @param {string[]} path */
function schemas(root, path) {
  let nodes = flat(root, root);
  for (const part of path) {
    nodes = entries(root, nodes).flatMap((node) => flat(root, node.properties?.[part] ?? (typeof node.additionalProperties === "object" ? node.additionalProperties : undefined)));
  }
  return entries(root, nodes);
}

/** Of several kinds of a table those that its keys allow: `shape = "plane"` leaves the planes. @param {Schema[]} nodes @param {Record<string, string>} keys */
function fitting(nodes, keys) {
  const fit = nodes.filter((node) => Object.entries(node.properties ?? {}).every(([key, one]) => !(/** @type {any} */ (one)).const || keys[key] === undefined || keys[key] === String(/** @type {any} */ (one).const)));
  return fit.length ? fit : nodes;
}

/** Descriptions of a key, as far as they differ. @param {any[]} all */
const helps = (all) => [...new Set(all.map((one) => one.description).filter(Boolean))].join("; or ");

/**
 * What can stand at a caret, and what the key there means.
 * @param {Schema} root schema of scenes
 * @param {string} text
 * @param {number} caret
 * @returns {{candidates: Candidate[], help: string, from: number, word: string}}
 */
export function complete(root, text, caret) {
  const { kind, path, key, word, from, keys } = context(text, caret);
  const nothing = { candidates: [], help: "", from, word };
  if (kind === "none") return nothing;
  const nodes = fitting(schemas(root, path), keys);
  /** @type {Map<string, any[]>} */
  const properties = new Map();
  for (const node of nodes) for (const [name, one] of Object.entries(node.properties ?? {})) properties.set(name, [...(properties.get(name) ?? []), one]);
  if (kind === "value") {
    const found = key ? properties.get(key) ?? schemas(root, [...path, ...key.split(".")]) : nodes;
    const values = found.flatMap((one) => flat(root, one)).flatMap((one) => entries(root, [one])).flatMap((one) => {
      if ("const" in one) return [{ text: JSON.stringify(one.const), help: one.description ?? "" }];
      if (one.enum) return one.enum.map((/** @type {any} */ value) => ({ text: JSON.stringify(value), help: "" }));
      return one.type === "boolean" ? [{ text: "true", help: "" }, { text: "false", help: "" }] : [];
    });
    // Materials are those that the scene has.
    if (key === "material" || key === "materials") for (const [, name] of text.matchAll(/^[ \t]*\[materials\.([A-Za-z0-9_-]+)/gm)) values.push({ text: JSON.stringify(name), help: "" });
    const seen = new Set();
    return { candidates: values.filter((one) => one.text.startsWith(word) && one.text !== word && !seen.has(one.text) && seen.add(one.text)), help: `${key}: ${helps(found)}`, from, word };
  }
  const all = [...properties].filter(([name]) => name.startsWith(word) && (kind === "head" || keys[name] === undefined));
  const tables = all.filter(([, found]) => kind !== "head" || found.some((one) => flat(root, one).some((node) => node.properties || node.items || typeof node.additionalProperties === "object")));
  return { candidates: tables.map(([name, found]) => ({ text: name, help: helps(found) })).filter((one) => one.text !== word), help: properties.has(word) ? `${word}: ${helps(properties.get(word) ?? [])}` : "", from, word };
}
