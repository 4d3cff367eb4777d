// Show the knit of a job, scrubbed through its test and coloured by what its yarn bears.
import { Color, Vector3 } from "./vendor/three.js";
import { ask } from "./api.js";
import { h, put } from "./dom.js";
import { rest } from "./reach.js";
import { FIELDS, Scale } from "./scale.js";
import { Stage } from "./stage.js";
import { SIDES, atNodes, fill, unpack, widen } from "./tube.js";
import { strains } from "./words.js";

const KEPT = 80;
const BEAT = 150;
const KEYS = "Drag to turn, scroll to zoom. With the keyboard, on the picture: arrows turn, + and − zoom, Home looks from above, Page Up and Page Down step through the test.";

/** Return the largest strain of a frame. */
const stretch = ({ strain }) => Math.max(0, ...Object.values(strain));

export class Knit {
  /** Throws where there is no WebGL, and has then put nothing on the page. */
  constructor(host, job, index, signal) {
    Object.assign(this, { job, index, signal, cache: new Map(), at: 0, field: "axial", playing: false });
    this.canvas = h("canvas", { tabindex: "0", role: "img", "aria-describedby": "knit-keys", onkeydown: (event) => this.key(event) });
    const box = h("div", { class: "knit" }, this.canvas);
    this.stage = new Stage(this.canvas, index, signal);
    this.slider = h("input", { type: "range", id: "frame", min: 0, max: index.frames.length - 1, value: 0, oninput: () => this.go(Number(this.slider.value)) });
    this.play = h("button", { type: "button", onclick: () => (this.playing ? this.stop() : this.start()) }, "Play");
    this.select = h("select", { id: "field", onchange: () => { this.field = this.select.value; this.go(this.at); } },
      Object.entries(FIELDS).map(([name, field]) => h("option", { value: name }, field.name)));
    this.where = h("output", { for: "frame" });
    this.scale = new Scale();
    host.append(
      h("div", { class: "bar" }, h("label", {}, "Colour by ", this.select), this.play, h("label", { class: "bar test" }, "Test ", this.slider), this.where),
      box,
      this.scale.node,
      h("p", { id: "knit-keys", class: "faint" }, KEYS));
    signal.addEventListener("abort", () => this.stop());
    window.addEventListener("reached", () => this.go(this.at), { signal });
  }

  key(event) {
    const last = this.index.frames.length - 1;
    if (event.key === "PageUp") this.go(Math.min(this.at + 1, last));
    else if (event.key === "PageDown") this.go(Math.max(this.at - 1, 0));
    else if (!this.stage.key(event.key)) return;
    event.preventDefault();
  }

  async start() {
    this.playing = true;
    this.play.textContent = "Pause";
    while (this.playing && await this.go((this.at + 1) % this.index.frames.length)) await rest(BEAT);
    this.stop();
  }

  stop() {
    this.playing = false;
    this.play.textContent = "Play";
  }

  /** Take up frames that came since; who looks at the last one goes on to the new last one. */
  extend(index) {
    const atEnd = this.at === this.index.frames.length - 1;
    this.index = index;
    this.slider.max = index.frames.length - 1;
    return this.go(atEnd && !this.playing ? index.frames.length - 1 : this.at);
  }

  async frame(k) {
    if (!this.cache.has(k)) {
      if (this.cache.size > KEPT) this.cache.delete(this.cache.keys().next().value);
      const found = await (await ask(`v1/jobs/${this.job}/frames/${k}`, { signal: this.signal })).arrayBuffer();
      this.cache.set(k, unpack(found, this.index));
    }
    return this.cache.get(k);
  }

  /** Show a frame; tell whether it could be fetched. */
  async go(k) {
    this.at = k;
    this.slider.value = k;
    const { time, strain, phase, cycle } = this.index.frames[k];
    const place = `${time.toFixed(1)} s, ${phase} ${cycle}: ${strains(strain)}`;
    this.slider.setAttribute("aria-valuetext", place);
    let shape;
    try {
      const fit = await this.fitted();
      shape = await this.frame(k);
      if (this.at !== k) return true;
      this.paint(shape, fit);
    } catch (error) {
      if (error.name !== "AbortError") put(this.where, `${place}: not shown, ${error.message}`);
      return false;
    }
    put(this.where, place);
    this.canvas.setAttribute("aria-label", `The knit at ${place}, coloured by ${FIELDS[this.field].name}`);
    return true;
  }

  /** Return what brings the knit to the size of the stage: the same in all frames, so that stretching shows. */
  async fitted() {
    const { frames } = this.index;
    const widest = frames.reduce((most, frame, k) => (stretch(frame) > stretch(frames[most]) ? k : most), 0);
    if (this.fit?.widest === widest) return this.fit;
    const box = { low: new Vector3(Infinity, Infinity, Infinity), high: new Vector3(-Infinity, -Infinity, -Infinity) };
    for (const k of new Set([0, widest])) widen(box, (await this.frame(k)).nodes);
    const middle = box.low.clone().add(box.high).divideScalar(2);
    this.fit = { widest, middle, scale: 1.65 / Math.max(...box.high.sub(box.low).toArray()) };
    return this.fit;
  }

  paint(shape, fit) {
    const { position, normal, color } = this.stage.geometry.attributes;
    fill(shape.nodes, this.index, fit, position.array, normal.array);
    this.scale.set(this.field, this.index.range[this.field]);
    const tint = new Color();
    atNodes(shape[this.field], this.index.strands, this.field !== "contact").forEach((value, k) => {
      this.scale.colour(value, tint);
      for (let side = 0; side < SIDES; side += 1) tint.toArray(color.array, 3 * (k * SIDES + side));
    });
    this.stage.update(shape.axial);
  }
}
