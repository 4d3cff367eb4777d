// Make an editor of YAML that marks what the service finds wrong.
import {
  EditorState, EditorView, HighlightStyle, defaultKeymap, drawSelection, highlightActiveLine, history, historyKeymap,
  indentUnit, keymap, lineNumbers, lintGutter, linter, syntaxHighlighting, tags, yaml,
} from "./vendor/codemirror.js";
import { hints } from "./hints.js";

const DELAY = 400;
const CHECK = "check";
const LOOK = HighlightStyle.define([
  { tag: [tags.propertyName, tags.definition(tags.propertyName)], color: "var(--link)" },
  { tag: [tags.number, tags.bool], color: "var(--number)" },
  { tag: tags.comment, color: "var(--faint)", fontStyle: "italic" },
]);

/** Return where the places that the service names lie in a text, as the editor wants them. */
function marks(places, doc) {
  return places.map(({ detail, line, column }) => {
    const found = doc.line(Math.min(line ?? 1, doc.lines));
    const from = Math.min(found.from + (column ?? 1) - 1, found.to);
    return { from, to: Math.max(found.to, from), severity: "error", message: detail };
  });
}

export class Editor {
  /**
   * @param {object} parts `parent` node, `label` (id of its name), `text`, `changed()` after a change, `submit()`,
   *   `check()`, which returns what is wrong: places with a line, a column and a detail, and what `hints` needs: `schema()`
   *   and `names(key)`
   */
  constructor({ parent, label, text, changed, submit, check, schema, names }) {
    this.view = new EditorView({
      parent,
      state: EditorState.create({
        doc: text,
        extensions: [
          hints({ schema, names }),
          keymap.of([{ key: "Mod-Enter", run: () => { submit(); return true; } }, ...defaultKeymap, ...historyKeymap]),
          lineNumbers(), history(), drawSelection(), highlightActiveLine(), indentUnit.of("  "), yaml(), syntaxHighlighting(LOOK),
          lintGutter(),
          linter(async (view) => marks(await check(), view.state.doc), {
            delay: DELAY,
            needsRefresh: ({ transactions }) => transactions.some((one) => one.isUserEvent(CHECK)),
          }),
          EditorView.updateListener.of((update) => { if (update.docChanged) changed(); }),
          EditorView.contentAttributes.of({ "aria-labelledby": label, spellcheck: "false" }),
        ],
      }),
    });
  }

  get text() {
    return this.view.state.doc.toString();
  }

  /** Replace the whole text; undo brings back what stood there. */
  replace(text) {
    this.view.dispatch({ changes: { from: 0, to: this.view.state.doc.length, insert: text }, userEvent: "input" });
  }

  /** Check again although nothing was typed. */
  recheck() {
    this.view.dispatch({ userEvent: CHECK });
  }
}
