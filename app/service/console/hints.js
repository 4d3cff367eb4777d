// Complete keys and values in an editor, and explain them, from the JSON Schema of its file.
import {
  StateEffect, StateField, autocompletion, closeCompletion, completionKeymap, hoverTooltip, keymap, pickedCompletion, showTooltip,
  startCompletion,
} from "./vendor/codemirror.js";
import { h } from "./dom.js";
import { keyAt, placeAt } from "./place.js";
import { fieldsAt, helpOf, schemasAt, unitsOf, valuesOf } from "./schema.js";

const NUMBER = /^[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?\s+/;
/** Behind these a key or a value begins. */
const OPENED = /[{[]$|[-,:] $/;
const MOST_WORDS = 12;
/** Width that an explanation needs beside a list [px]. */
const ROOM = 300;

const capital = (text) => text[0].toUpperCase() + text.slice(1);

/** Return what is known of a field as an element. */
function explained({ name, title, described, values, units, default: usual }) {
  const shown = values.length > MOST_WORDS ? [...values.slice(0, MOST_WORDS), "…"] : values;
  const facts = [["Words", shown.join(", ")], ["Units", units.join(", ")], ["Default", usual]];
  // Of a step the title is its description.
  const told = described && !described.startsWith(title) && described.split("\n\n")[0].replace(/\.$/, "");
  const rows = facts.filter(([, text]) => text);
  return h("div", { class: "explained" },
    h("p", {}, h("b", {}, name), title && `: ${title}`), told && h("p", {}, `${capital(told)}.`),
    rows.length > 0 && h("dl", {}, rows.map(([label, text]) => [h("dt", {}, label), h("dd", {}, text)])));
}

/** Write a key with its colon, and offer its values where there are words for it. */
function applyKey(values, colonFollows) {
  return (view, completion, from, to) => {
    const insert = colonFollows ? completion.label : `${completion.label}: `;
    view.dispatch({
      changes: { from, to, insert }, selection: { anchor: from + insert.length }, userEvent: "input.complete",
      annotations: pickedCompletion.of(completion),
    });
    if (values.length && !colonFollows) startCompletion(view);
  };
}

function keyOptions(root, { levels, siblings, colonFollows }) {
  return fieldsAt(root, levels, siblings).map(({ name, schema, required }, place) => {
    const help = helpOf(name, [schema], root);
    return {
      label: name, detail: required ? "must be said" : undefined, type: "property", boost: -place,
      info: () => explained(help), apply: applyKey(valuesOf([schema], root), colonFollows),
    };
  });
}

// The list itself shows the words.
const valueOptions = (values, help) => values.map((label, place) => (
  { label, type: "enum", boost: -place, info: help && (() => explained({ ...help, values: [] })) }));

/** Return the help of the key whose value, or an item of it, is at some levels. */
function helpAt(root, levels) {
  const last = levels.findLastIndex(({ key }) => key !== undefined);
  const path = levels.slice(0, last + 1);
  const schemas = schemasAt(root, path);
  return schemas.length ? helpOf(path.at(-1).key, schemas, root) : undefined;
}

/** Return the completions at a place: `names(key)` are words that the schema does not know, as of one's own materials. */
function offered(root, names, place, typed) {
  const schemas = schemasAt(root, place.levels);
  if (place.kind === "key") {
    const options = keyOptions(root, place);
    // An item that has begun may be a word as well as a mapping.
    return place.alone ? [...options, ...valueOptions(valuesOf(schemas, root), undefined)] : options;
  }
  if (NUMBER.test(typed)) return unitsOf(schemas, root).map((label, place) => ({ label, type: "unit", boost: -place }));
  const key = place.levels.findLast((level) => level.key !== undefined)?.key;
  const values = [...new Set([...valuesOf(schemas, root), ...names(key)])];
  const item = place.levels.at(-1)?.item !== undefined;
  // An item of a list in brackets may be a mapping that begins with its key.
  return [...valueOptions(values, helpAt(root, place.levels)), ...(item ? keyOptions(root, { ...place, siblings: [] }) : [])];
}

function completions({ schema, names }) {
  return ({ state, pos, explicit }) => {
    const root = schema();
    const place = root && placeAt(state.doc.toString(), pos);
    if (!place) return null;
    const typed = state.sliceDoc(place.from, pos);
    // On a line that is still empty one asks for it: the next press of Enter may mean a new line.
    if (!explicit && !typed && !OPENED.test(state.sliceDoc(Math.max(0, pos - 2), pos))) return null;
    const options = offered(root, names, place, typed);
    const from = place.kind === "value" ? place.from + (typed.match(NUMBER)?.[0].length ?? 0) : place.from;
    return options.length ? { from, to: Math.max(pos, place.to), options, validFor: /^[\w.-]*$/ } : null;
  };
}

/** Return the tooltip of the key at a position; `wide` takes that of its value too. */
function tooltip(schema, text, pos, wide) {
  const root = schema();
  const found = root && keyAt(text, pos, wide);
  const help = found && helpAt(root, found.levels);
  return help ? { pos: found.from, end: found.to, above: true, create: () => ({ dom: explained(help) }) } : null;
}

const explain = StateEffect.define();

/** Hold the explanation that was asked for by the keyboard, until something else is done. */
const asked = StateField.define({
  create: () => null,
  update(shown, { effects, docChanged, selection }) {
    const found = effects.find((effect) => effect.is(explain));
    if (found) return found.value;
    return docChanged || selection ? null : shown;
  },
  provide: (field) => showTooltip.from(field),
});

function explainHere(schema) {
  return (view) => {
    const { state } = view;
    const { head } = state.selection.main;
    const shown = tooltip(schema, state.doc.toString(), head, true);
    // The key itself may be out of sight, the cursor is not.
    view.dispatch({ effects: explain.of(state.field(asked) || !shown ? null : { ...shown, pos: head, end: undefined }) });
    return true;
  };
}

function close(view) {
  if (!view.state.field(asked)) return false;
  view.dispatch({ effects: explain.of(null) });
  return true;
}

/** Close the list, which a browser would take the focus into, and let it go on to what is next. */
function leave(view) {
  closeCompletion(view);
  return false;
}

/** Put what explains a completion beside the list where there is room, else below or above it. */
function beside(view, list, option, info, space) {
  const top = Math.max(0, Math.min(option.top, space.bottom - (info.bottom - info.top)) - list.top);
  if (space.right - list.right > ROOM) return { style: `top: ${top}px; left: 100%`, class: "beside-list" };
  if (list.left - space.left > ROOM) return { style: `top: ${top}px; right: 100%`, class: "beside-list" };
  const below = space.bottom - list.bottom > info.bottom - info.top;
  // Both begin at the left edge of what is seen.
  return { style: `${below ? "top" : "bottom"}: 100%; left: ${space.left - list.left}px`, class: "beyond-list" };
}

/**
 * Return the extensions of an editor that completes and explains.
 *
 * @param {object} parts `schema()`, the JSON Schema of the file or nothing until it is there, and `names(key)`, words
 *   for the value of a key that it does not know
 */
export function hints({ schema, names }) {
  return [
    autocompletion({ override: [completions({ schema, names })], icons: false, maxRenderedOptions: 60, positionInfo: beside }),
    hoverTooltip((view, pos) => tooltip(schema, view.state.doc.toString(), pos, false)),
    asked,
    keymap.of([{ key: "Tab", run: leave }, { key: "F1", run: explainHere(schema) }, { key: "Escape", run: close }, ...completionKeymap]),
  ];
}
