// Edit a protocol, its materials and files, checked by the service as one types, and submit them.
import { Problem, Unreachable, ask, get, report, sendProtocol } from "./api.js";
import { Beside } from "./beside.js";
import { entitle, h, put, tell } from "./dom.js";
import { Busy } from "./busy.js";
import * as drafts from "./drafts.js";
import { Editor } from "./editor.js";
import { Library } from "./library.js";
import { keysUnder } from "./place.js";
import { Plan } from "./plan.js";
import { Schemas } from "./schemas.js";

const HINT = "For a protocol that says `materials: NAME.yaml`: the text of that file. Empty for none.";

const KEYS = "Ctrl-Space completes, F1 explains the word at the cursor, Ctrl-Enter submits; Escape, then Tab leaves the editor.";

class NewTest {
  constructor(place, signal, starter) {
    Object.assign(this, { signal, starter, wrong: [], turn: 0, busy: false, schemas: new Schemas(signal) });
    this.verdict = h("p", { role: "status" });
    this.seeded = h("p", { class: "warning bar", hidden: true });
    this.drawing = new Busy();
    this.checking = new Busy();
    this.pictures = h("input", { type: "checkbox", checked: true });
    this.options = h("label", { class: "bar field", hidden: true }, this.pictures, "Plots and pictures of every test");
    this.plan = new Plan();
    this.picture = h("figure", { hidden: true });
    this.submit = h("button", { type: "button", class: "main", disabled: true, onclick: () => this.send() }, "Submit");
    this.see = h("button", { type: "button", onclick: () => this.draw() }, "Draw the knit");
    const again = h("button", { type: "button", onclick: () => this.startOver() }, "Start over");
    this.library = new Library((example) => this.seed(example, "the example"), signal);
    const examples = h("button", { type: "button", onclick: () => this.library.open() }, "Examples");
    this.beside = new Beside({ changed: () => { this.changed(); this.protocol.recheck(); }, materials: (text) => this.bring(text) });
    const first = h("div", { class: "editor" }), second = h("div", { class: "editor small" });
    const kept = drafts.kept();
    place.append(
      h("div", { class: "bar spread" }, h("h1", {}, "New test"), h("div", { class: "bar" }, this.options, examples, again, this.see, this.submit)),
      this.seeded,
      h("div", { class: "two" },
        h("section", {}, h("h2", { id: "protocol-label" }, "Protocol"), first, this.verdict, this.checking.node,
          h("p", { class: "faint" }, KEYS),
          h("details", { open: Boolean(kept.materials) }, h("summary", { id: "materials-label" }, "Materials"), h("p", { class: "faint" }, HINT), second),
          this.beside.node),
        h("section", {}, h("h2", {}, "What it would do"), this.drawing.node, this.plan.node, this.picture)),
      this.library.node);
    const submit = () => this.send();
    this.protocol = new Editor({
      submit, parent: first, label: "protocol-label", text: kept.protocol ?? starter,
      check: () => this.check(), changed: () => this.changed(),
      schema: () => this.schemas.protocol, names: (key) => this.names(key),
    });
    // The protocol is what is checked, with these materials.
    this.materials = new Editor({
      submit, parent: second, label: "materials-label", text: kept.materials ?? "",
      check: () => this.wrong, changed: () => { this.changed(); this.protocol.recheck(); },
      schema: () => this.schemas.material, names: () => [],
    });
    signal.addEventListener("abort", () => [this.protocol, this.materials].forEach(({ view }) => view.destroy()));
    window.addEventListener("reached", () => this.protocol.recheck(), { signal });
    this.protocol.view.focus();
  }

  get texts() {
    return { protocol: this.protocol.text, materials: this.materials.text, files: this.beside.texts };
  }

  /** Return the words for a value that no schema knows: materials and files of one's own. */
  names(key) {
    if (key === "material") return [...keysUnder(this.materials.text, "materials"), ...keysUnder(this.protocol.text, "materials")];
    return key === "centreline" || key === "table" ? this.beside.names : [];
  }

  /** Keep the drafts, and take nothing for valid until the service has said so of these very texts. */
  changed() {
    const { texts } = this;
    drafts.keep(texts);
    this.turn += 1;
    this.judge("", "Checking …");
    this.plan.outdate();
    this.picture.className = "stale";
  }

  judge(kind, text) {
    this.verdict.className = kind;
    put(this.verdict, text);
    this.arm();
  }

  /** Offer to submit what is valid, once at a time. */
  arm() {
    this.submit.disabled = this.verdict.className !== "right" || this.busy;
  }

  /** Ask the service what it thinks of the texts, and return what is wrong in the protocol. */
  async check() {
    const turn = (this.turn += 1);
    const { texts } = this;
    let places = [];
    try {
      const { plan, sweep } = await this.checking.during("Checking", () => planOf(texts, this.signal));
      // Answers may overtake each other; only that to the last question counts.
      if (turn !== this.turn) return [];
      this.swept = Boolean(sweep);
      this.options.hidden = !sweep;
      put(this.submit, sweep ? `Submit ${sweep.count} tests` : "Submit");
      this.judge("right", sweep ? `This sweep is valid: ${sweep.count} tests.` : "This protocol is valid.");
      this.plan.show(plan, sweep);
    } catch (error) {
      if (turn !== this.turn || error.name === "AbortError") return [];
      this.plan.outdate();
      this.judge("wrong", error instanceof Unreachable ? "Not checked, as the service cannot be reached; it will be as soon as it can." : error.message);
      if (error instanceof Problem) places = error.problem.errors?.length ? error.problem.errors : [{ detail: error.message }];
    }
    // A place in another file than the protocol says in which.
    const elsewhere = places.filter(({ file }) => file);
    this.wrong = elsewhere.filter(({ file }) => !Object.hasOwn(texts.files, file));
    this.beside.mark(elsewhere);
    this.materials.recheck();
    return places.filter(({ file }) => !file);
  }

  startOver() {
    this.protocol.replace(this.starter);
    this.materials.replace("");
    this.protocol.view.focus();
  }

  /** Take up another protocol; what was written is put aside, a press away, also later. Undo brings it back too, and its files stay. */
  seed({ name, protocol, materials, files = {} }, of = "the protocol of") {
    const { texts } = this;
    if (texts.protocol !== this.starter && texts.protocol !== protocol) drafts.putAside(texts);
    this.take({ protocol, materials });
    this.beside.put(files);
    this.offer(`This is ${of} ${name}.`);
    this.protocol.view.focus();
  }

  take({ protocol, materials }) {
    this.protocol.replace(protocol);
    this.bring(materials);
  }

  /** Take the text of a file of materials. */
  bring(materials) {
    this.materials.replace(materials);
    if (materials) this.materials.view.dom.closest("details").open = true;
  }

  /** Offer the draft that was put aside last, if one was. */
  offer(why = "") {
    const count = drafts.aside().length;
    const done = (texts) => {
      if (texts) {
        this.take(texts);
        this.beside.replace(texts.files ?? {});
      }
      this.offer();
      this.protocol.view.focus();
    };
    this.seeded.hidden = !why && !count;
    this.seeded.replaceChildren(`${why}${count ? " Your draft from before is kept." : ""}`, ...(count ? [
      h("button", { type: "button", onclick: () => done(drafts.takeBack()) }, "Back to my draft"),
      h("button", { type: "button", onclick: () => { drafts.takeBack(); done(); } }, "Forget it")] : []));
  }

  async send() {
    if (this.submit.disabled) return;
    this.busy = true;
    this.arm();
    try {
      const key = crypto.randomUUID?.() ?? `${Date.now()}-${Math.random()}`;
      const route = this.swept ? `v1/sweeps?pictures=${this.pictures.checked}` : "v1/jobs";
      const headers = { "Idempotency-Key": key };
      const sent = await this.checking.during("Submitting", async () => (await sendProtocol(route, this.texts, { headers, asJson: this.swept })).json());
      tell(this.swept ? `${sent.count} jobs: queued` : `${sent.name}: ${sent.state}`);
      if (!this.signal.aborted) location.hash = this.swept ? `#/sweeps/${sent.sweep}` : `#/jobs/${sent.id}`;
    } catch (error) {
      tell(error.message);
    }
    this.busy = false;
    this.arm();
  }

  async draw() {
    this.see.disabled = true;
    const { texts } = this;
    try {
      const found = await this.drawing.during("Drawing the knit", () => sendProtocol("v1/specimens:preview", texts, { headers: { Accept: "image/png" }, signal: this.signal }));
      const source = URL.createObjectURL(await found.blob());
      this.picture.replaceChildren(h("img", { class: "specimen", src: source, alt: "the knit as it is made, with its boundary sites", onload: () => URL.revokeObjectURL(source) }));
      this.picture.className = texts.protocol === this.protocol.text ? "" : "stale";
      this.picture.hidden = false;
    } catch (error) {
      report(error);
    }
    this.see.disabled = false;
  }
}

/** Ask what texts would do: the plan of one test, or of a sweep with that of its first test. */
async function planOf(texts, signal) {
  try {
    return { plan: await (await sendProtocol("v1/protocols:validate", texts, { signal })).json() };
  } catch (error) {
    if (!error.problem?.type?.endsWith(":swept")) throw error;
  }
  const sweep = await (await sendProtocol("v1/sweeps:validate", texts, { signal, asJson: true })).json();
  return { plan: sweep.first, sweep };
}

/** @param {string} job whose protocol is to be edited, if one is */
export async function showNew(place, signal, job) {
  entitle("New test");
  const [starter, seed] = await Promise.all([ask("starter.yaml", { signal }).then((found) => found.text()), job && get(`v1/jobs/${job}/protocol`, signal)]);
  signal.throwIfAborted();
  const test = new NewTest(place, signal, starter);
  if (!seed) return test.offer();
  // Loaded again, the page shows what has been written since.
  history.replaceState(null, "", "#/new");
  return test.seed(seed);
}
