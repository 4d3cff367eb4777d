// Find the place of a YAML text that the cursor is at: the keys and items that lead to it.
import { yamlLanguage } from "./vendor/codemirror.js";

/** Stands in the text for what is being typed, so that the rest is read as it will be. */
const MARK = "knitlabcursor";
const WORD = /[\w.-]*$/;
const REST = /^[\w.-]*/;
const VALUE = /[\w.-]+:\s+([^,:[\]{}#'"|>&*!]*)$/;
const CLOSED = /[}\]"']\s*$/;
const LINE_BEGINS = /^\s*(?:- +)*$/;

const parse = (text) => yamlLanguage.parser.parse(text);
const bare = (text) => text.trim().replace(/^(["'])(.*)\1$/s, "$2");

function keyOf(pair, text) {
  const key = pair.getChild("Key");
  return key ? bare(text.slice(key.from, key.to)) : "";
}

const keysBeside = (pair, text) => pair.parent.getChildren("Pair").filter(({ from }) => from !== pair.from).map((one) => keyOf(one, text));

/** Return the levels that lead to a node, its own among them. */
function levelsOf(node, text) {
  const levels = [];
  for (let at = node; at; at = at.parent) {
    if (at.name === "Pair") levels.unshift({ key: keyOf(at, text), siblings: keysBeside(at, text) });
    else if (at.name === "Item") levels.unshift({ item: at.parent.getChildren("Item").findIndex(({ from }) => from === at.from) });
  }
  return levels;
}

/** Return what is being typed, if it may be: where it begins and ends, and what has to follow it to be read as meant. */
function typed(text, pos) {
  const before = text.slice(text.lastIndexOf("\n", pos - 1) + 1, pos);
  const to = pos + text.slice(pos).match(REST)[0].length;
  const value = before.match(VALUE);
  if (value) return { from: pos - value[1].length, to, colon: "" };
  const from = pos - before.match(WORD)[0].length;
  const opening = before.slice(0, before.length - (pos - from));
  // Behind what is complete there is no place.
  if (CLOSED.test(opening)) return undefined;
  const begins = LINE_BEGINS.test(opening);
  return { from, to, begins, colon: begins && !/^\s*:/.test(text.slice(to)) ? ":" : "" };
}

/**
 * Return the place at which something is being typed, or nothing where a text of another kind stands (a comment, a
 * quoted text): `kind` ("key" or "value"), `from` and `to`, its `levels`, of a key the `siblings`, whether it is
 * `alone` in an item of a list (which may be a value instead), and whether a `colon` follows it.
 */
export function placeAt(text, pos) {
  const found = typed(text, pos);
  if (!found) return undefined;
  const { from, to, begins, colon } = found;
  const marked = `${text.slice(0, from)}${MARK}${colon}${text.slice(to)}`;
  const node = parse(marked).resolveInner(from + 1, 1);
  if (node.name !== "Literal" || marked.slice(node.from, node.to).trim() !== MARK) return undefined;
  if (node.parent.name !== "Key") return { kind: "value", from, to, levels: levelsOf(node, marked) };
  const levels = levelsOf(node, marked);
  const { siblings } = levels.pop();
  const colonFollows = /^\s*:/.test(text.slice(to));
  return { kind: "key", from, to, levels, siblings, alone: siblings.length === 0 && levels.at(-1)?.item !== undefined, begins, colonFollows };
}

/** Return the key at a position, or (`wide`) that whose value is there: where it stands, and its levels. */
export function keyAt(text, pos, wide = false) {
  const tree = parse(text);
  for (const side of [-1, 1]) {
    for (let at = tree.resolveInner(pos, side); at; at = at.parent) {
      const pair = at.name === "Key" ? at.parent : wide && at.name === "Pair" ? at : undefined;
      const key = pair?.getChild("Key");
      if (key) return { from: key.from, to: key.to, levels: levelsOf(pair, text) };
    }
  }
  return undefined;
}

/** Return the keys of the mapping under a key at the top of a text. */
export function keysUnder(text, name) {
  const top = parse(text).topNode.firstChild?.getChild("BlockMapping");
  const pair = top?.getChildren("Pair").find((one) => keyOf(one, text) === name);
  const mapping = pair?.getChild("BlockMapping") ?? pair?.getChild("FlowMapping");
  return (mapping?.getChildren("Pair") ?? []).map((one) => keyOf(one, text));
}
