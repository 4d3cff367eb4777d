// Edit a protocol and its materials, checked by the service as one types, and submit them.
import { Problem, Unreachable, ask, report, sendProtocol } from "./api.js";
import { entitle, h, put, tell } from "./dom.js";
import { Editor } from "./editor.js";
import { Plan } from "./plan.js";

const DRAFTS = { protocol: "knitlab-draft", materials: "knitlab-draft-materials" };
const HINT = "For a protocol that says `materials: NAME.yaml`: the text of that file. Empty for none.";

/** Tell of which of the two texts a place is. */
const ofMaterials = ({ pointer }, texts) => Boolean(texts.materials.trim()) && /^\/materials(\/|$)/.test(pointer ?? "");

class NewTest {
  constructor(place, signal, starter) {
    Object.assign(this, { signal, starter, wrong: [], turn: 0, busy: false });
    this.verdict = h("p", { role: "status" });
    this.plan = new Plan();
    this.picture = h("figure", { hidden: true });
    this.submit = h("button", { type: "button", class: "main", disabled: true, onclick: () => this.send() }, "Submit");
    this.see = h("button", { type: "button", onclick: () => this.draw() }, "Draw the knit");
    const again = h("button", { type: "button", onclick: () => this.startOver() }, "Start over");
    const first = h("div", { class: "editor" }), second = h("div", { class: "editor small" });
    const kept = Object.fromEntries(Object.entries(DRAFTS).map(([name, key]) => [name, localStorage.getItem(key)]));
    place.append(
      h("div", { class: "bar spread" }, h("h1", {}, "New test"), h("div", { class: "bar" }, again, this.see, this.submit)),
      h("div", { class: "two" },
        h("section", {}, h("h2", { id: "protocol-label" }, "Protocol"), first, this.verdict,
          h("p", { class: "faint" }, "Ctrl-Enter submits; Escape, then Tab leaves the editor."),
          h("details", { open: Boolean(kept.materials) }, h("summary", { id: "materials-label" }, "Materials"), h("p", { class: "faint" }, HINT), second)),
        h("section", {}, h("h2", {}, "What it would do"), this.plan.node, this.picture)));
    const submit = () => this.send();
    this.protocol = new Editor({
      submit, parent: first, label: "protocol-label", text: kept.protocol ?? starter,
      check: () => this.check(), changed: () => this.changed(),
    });
    // The protocol is what is checked, with these materials.
    this.materials = new Editor({
      submit, parent: second, label: "materials-label", text: kept.materials ?? "",
      check: () => this.wrong, changed: () => { this.changed(); this.protocol.recheck(); },
    });
    signal.addEventListener("abort", () => [this.protocol, this.materials].forEach(({ view }) => view.destroy()));
    window.addEventListener("reached", () => this.protocol.recheck(), { signal });
    this.protocol.view.focus();
  }

  get texts() {
    return { protocol: this.protocol.text, materials: this.materials.text };
  }

  /** Keep the drafts, and take nothing for valid until the service has said so of these very texts. */
  changed() {
    const { texts } = this;
    for (const [name, key] of Object.entries(DRAFTS)) localStorage.setItem(key, texts[name]);
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
      const plan = await (await sendProtocol("v1/protocols:validate", texts, { signal: this.signal })).json();
      // Answers may overtake each other; only that to the last question counts.
      if (turn !== this.turn) return [];
      this.judge("right", "This protocol is valid.");
      this.plan.show(plan);
    } catch (error) {
      if (turn !== this.turn || error.name === "AbortError") return [];
      this.plan.outdate();
      this.judge("wrong", error instanceof Unreachable ? "Not checked, as the service cannot be reached; it will be as soon as it can." : error.message);
      if (error instanceof Problem) places = error.problem.errors?.length ? error.problem.errors : [{ detail: error.message }];
    }
    this.wrong = places.filter((one) => ofMaterials(one, texts));
    this.materials.recheck();
    return places.filter((one) => !ofMaterials(one, texts));
  }

  startOver() {
    this.protocol.replace(this.starter);
    this.materials.replace("");
    this.protocol.view.focus();
  }

  async send() {
    if (this.submit.disabled) return;
    this.busy = true;
    this.arm();
    try {
      const key = crypto.randomUUID?.() ?? `${Date.now()}-${Math.random()}`;
      const job = await (await sendProtocol("v1/jobs", this.texts, { headers: { "Idempotency-Key": key } })).json();
      tell(`${job.name}: ${job.state}`);
      if (!this.signal.aborted) location.hash = `#/jobs/${job.id}`;
    } catch (error) {
      tell(error.message);
    }
    this.busy = false;
    this.arm();
  }

  async draw() {
    this.see.disabled = true;
    tell("drawing the knit");
    const { texts } = this;
    try {
      const found = await sendProtocol("v1/specimens:preview", texts, { headers: { Accept: "image/png" }, signal: this.signal });
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

export async function showNew(place, signal) {
  entitle("New test");
  const starter = await (await ask("starter.yaml", { signal })).text();
  signal.throwIfAborted();
  new NewTest(place, signal, starter);
}
