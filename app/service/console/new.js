// Edit a protocol, checked by the service as one types, and submit it.
import {
  EditorState, EditorView, HighlightStyle, defaultKeymap, drawSelection, highlightActiveLine, history, historyKeymap,
  indentUnit, keymap, lineNumbers, lintGutter, linter, syntaxHighlighting, tags, yaml,
} from "./vendor/codemirror.js";
import { Problem, ask, sendProtocol } from "./api.js";
import { AXES, h, percent, si, span, tell } from "./dom.js";

const DRAFT = "knitlab-draft";
const LOOK = HighlightStyle.define([
  { tag: [tags.propertyName, tags.definition(tags.propertyName)], color: "var(--link)" },
  { tag: [tags.number, tags.bool], color: "var(--wale)" },
  { tag: tags.comment, color: "var(--faint)", fontStyle: "italic" },
]);

/** Return where in a text an error of the service lies, as the editor wants it. */
function marks(problem, doc) {
  const places = problem.errors?.length ? problem.errors : [{ detail: problem.detail }];
  return places.map(({ detail, line, column }) => {
    const found = doc.line(Math.min(line ?? 1, doc.lines));
    const from = Math.min(found.from + (column ?? 1) - 1, found.to);
    return { from, to: Math.max(found.to, from), severity: "error", message: detail };
  });
}

/** Return what a protocol would do, for people. */
function planned(plan) {
  const { specimen } = plan;
  return [
    plan.warnings.map((text) => h("p", { class: "warning" }, text)),
    h("dl", {},
      h("dt", {}, "Takes on the rig"), h("dd", {}, span(plan.duration_s)),
      h("dt", {}, "Rows of the log"), h("dd", {}, plan.rows),
      h("dt", {}, "Specimen"), h("dd", {}, `${specimen.nodes} nodes, yarn ${si(specimen.yarn_length_m, "m")}, narrowest gap ${si(specimen.clearance_m, "m")}`),
      h("dt", {}, "Hook to hook"), h("dd", {}, Object.entries(specimen.gauge_lengths_m).map(([axis, length]) => `${AXES[axis]} ${si(length, "m")}`).join(", ")),
      h("dt", {}, "Locking strain"), h("dd", {}, specimen.locking_strain ? percent(specimen.locking_strain) : "not estimated")),
    h("div", { class: "scroll", style: "max-height: 18rem; overflow-y: auto" }, h("table", {},
      h("thead", {}, h("tr", {}, ["Cycle", "Stroke", "Tag", "To", "Takes"].map((name) => h("th", { scope: "col" }, name)))),
      h("tbody", {}, plan.strokes.slice(0, 200).map((stroke) => h("tr", {},
        h("td", {}, stroke.cycle), h("td", {}, stroke.phase), h("td", {}, stroke.tag ?? ""),
        h("td", {}, Object.entries(stroke.end_m).map(([axis, end]) => `${AXES[axis]} ${si(end, "m")}`).join(", ")),
        h("td", {}, span(stroke.duration_s)))))))];
}

export async function showNew(page, signal, template) {
  const start = template ? null : localStorage.getItem(DRAFT);
  const text = start ?? (await (await ask("starter.yaml")).text());
  const host = h("div", { class: "editor" });
  const verdict = h("p", { role: "status" });
  const plan = h("div");
  const picture = h("div");
  const submit = h("button", { type: "button", class: "main", disabled: true, onclick: send }, "Submit");
  const see = h("button", { type: "button", onclick: draw }, "Draw the knit");
  const again = h("button", { type: "button", onclick: async () => { localStorage.removeItem(DRAFT); location.hash = "#/new/starter"; } }, "Start over");
  page.append(
    h("div", { class: "bar spread" }, h("h1", {}, "New test"), h("div", { class: "bar" }, again, see, submit)),
    h("div", { class: "two" },
      h("section", {}, h("h2", { id: "editor-label" }, "Protocol"), host, verdict,
        h("p", { class: "faint" }, "Ctrl-Enter submits; Escape, then Tab leaves the editor.")),
      h("section", {}, h("h2", {}, "What it would do"), plan, picture)));

  async function check(view) {
    const content = view.state.doc.toString();
    localStorage.setItem(DRAFT, content);
    try {
      const found = await (await sendProtocol("v1/protocols:validate", content)).json();
      verdict.className = "";
      verdict.textContent = "This protocol is valid.";
      plan.replaceChildren(...planned(found).flat());
      submit.disabled = false;
      return [];
    } catch (error) {
      submit.disabled = true;
      verdict.className = "wrong";
      verdict.textContent = error.message;
      return error instanceof Problem ? marks(error.problem, view.state.doc) : [];
    }
  }

  const view = new EditorView({
    parent: host,
    state: EditorState.create({
      doc: text,
      extensions: [
        keymap.of([{ key: "Mod-Enter", run: () => { send(); return true; } }, ...defaultKeymap, ...historyKeymap]),
        lineNumbers(), history(), drawSelection(), highlightActiveLine(), indentUnit.of("  "), yaml(), syntaxHighlighting(LOOK),
        lintGutter(), linter(check, { delay: 400 }),
        EditorView.contentAttributes.of({ "aria-labelledby": "editor-label", spellcheck: "false" }),
      ],
    }),
  });
  signal.addEventListener("abort", () => view.destroy());
  view.focus();

  async function send() {
    if (submit.disabled) return;
    submit.disabled = true;
    try {
      const key = crypto.randomUUID?.() ?? `${Date.now()}-${Math.random()}`;
      const job = await (await sendProtocol("v1/jobs", view.state.doc.toString(), { "Idempotency-Key": key })).json();
      tell(`${job.name}: ${job.state}`);
      location.hash = `#/jobs/${job.id}`;
    } catch (error) {
      tell(error.message);
      submit.disabled = false;
    }
  }

  async function draw() {
    see.disabled = true;
    tell("drawing the knit");
    try {
      const found = await (await sendProtocol("v1/specimens:preview", view.state.doc.toString(), { Accept: "image/png" })).blob();
      const source = URL.createObjectURL(found);
      picture.replaceChildren(h("img", { class: "specimen", src: source, alt: "the knit as it is made, with its boundary sites", onload: () => URL.revokeObjectURL(source) }));
    } catch (error) {
      tell(error.message);
    }
    see.disabled = false;
  }
}
