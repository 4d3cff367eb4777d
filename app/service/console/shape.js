// Show the knit of a job as soon as its record has shapes, or say why there is none.
import { get } from "./api.js";
import { h, put } from "./dom.js";
import { Knit } from "./knit.js";
import { FINAL } from "./states.js";

const SOON = 1000;
const LATER = 5000;

export class Shape {
  /** @param {(section: object) => void} measured is told the sections [m²] by axis once they are known */
  constructor(job, signal, measured) {
    Object.assign(this, { job, signal, measured });
    this.knit = null;
    this.why = h("p", { class: "faint" });
    this.node = h("section", {}, h("h2", {}, "Knit"), this.why);
  }

  /** Take up what the record holds now; return how long to wait for more [ms]. */
  async look({ state, progress }) {
    const over = FINAL.includes(state);
    let index;
    try {
      index = await get(`v1/jobs/${this.job}/frames`, this.signal);
    } catch (error) {
      if (error.problem?.status !== 409) throw error;
      if (this.knit) return SOON;
      put(this.why, over ? "No shape was recorded." : progress.rows ? "The record is being written, one moment." : "The test has not begun.");
      return SOON;
    }
    this.measured(index.section);
    if (index.frames.length) this.show(index, over);
    else put(this.why, over ? "No shape was recorded." : "No shape is recorded yet.");
    return LATER;
  }

  show(index, over) {
    if (this.knit) {
      this.knit.extend(index);
      return;
    }
    if (this.failed) return;
    try {
      this.knit = new Knit(this.node, this.job, index, this.signal);
    } catch (error) {
      // The rest of the page does without.
      this.failed = true;
      put(this.why, `The knit cannot be drawn here, as this browser gives no WebGL (${error.message}). Its pictures are among the files.`);
      return;
    }
    this.why.hidden = true;
    // A test that goes on is followed, one that is over is shown from its beginning.
    this.knit.go(over ? 0 : index.frames.length - 1);
  }
}
