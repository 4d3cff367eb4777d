// Hold which jobs are chosen, on whatever page that was done, and what can be done with them.
import { deleted } from "./deletion.js";
import { Busy } from "./busy.js";
import { h, put } from "./dom.js";

/** Most jobs that are laid over each other: more curves cannot be told apart. */
export const MOST = 12;

const chosen = new Map();

/** Return a box that chooses a job; it is kept as the job is told. */
export function box(job, changed) {
  const made = h("input", { type: "checkbox", "aria-label": `choose ${job.name} ${job.id.slice(0, 8)}` });
  made.checked = chosen.has(job.id);
  made.addEventListener("change", () => {
    if (made.checked) chosen.set(job.id, job);
    else chosen.delete(job.id);
    changed();
  });
  return made;
}

/** Hold the bar of what can be done with the chosen jobs. */
export class Choice {
  /**
   * @param {() => HTMLInputElement[]} boxes returns the boxes of the page
   * @param {() => void} gone is called when jobs have been deleted
   */
  constructor(boxes, gone) {
    Object.assign(this, { boxes, gone });
    this.count = h("span", { role: "status" });
    this.link = h("a", { class: "button main" }, "Compare");
    this.why = h("span", { class: "faint" });
    this.busy = new Busy();
    this.remove = h("button", { type: "button", onclick: () => this.delete() }, "Delete");
    this.none = h("button", { type: "button", onclick: () => this.clear() }, "Choose none");
    this.node = h("div", { class: "bar chosen", role: "group", "aria-label": "Chosen jobs" }, this.count, this.link, this.why, this.remove, this.none, this.busy.node);
    this.show();
  }

  show() {
    const count = chosen.size;
    put(this.count, count ? `${count} chosen` : "Choose jobs by the boxes to compare or delete them.");
    const fits = count >= 2 && count <= MOST;
    this.link.hidden = !fits;
    if (fits) this.link.href = `#/compare/${[...chosen.keys()].join(",")}`;
    put(this.why, count === 1 ? "Choose another to compare." : count > MOST ? `At most ${MOST} are compared.` : "");
    this.remove.hidden = this.none.hidden = !count;
  }

  /** Take up what became of the jobs meanwhile. */
  refresh(jobs) {
    for (const job of jobs) if (chosen.has(job.id)) chosen.set(job.id, job);
  }

  clear() {
    chosen.clear();
    for (const one of this.boxes()) one.checked = false;
    this.show();
    // The button that was pressed is gone.
    (this.boxes()[0] ?? document.getElementById("page")).focus();
  }

  async delete() {
    if (this.working) return;
    this.working = true;
    const gone = await deleted([...chosen.values()], this.busy);
    this.working = false;
    for (const id of gone) chosen.delete(id);
    this.show();
    if (!gone.length) return;
    document.getElementById("page").focus();
    this.gone();
  }
}

/** Take a job out of the chosen ones, as when it was deleted elsewhere. */
export const forget = (id) => chosen.delete(id);
