// Show a job's state, and the buttons for what can be asked of it.
import { post, report } from "./api.js";
import { deleted } from "./deletion.js";
import { h, put, tell } from "./dom.js";
import { FINAL } from "./states.js";

const CAN = {
  pause: (job) => ["queued", "running"].includes(job.state) && !job.wanted,
  resume: (job) => job.state === "paused",
  cancel: (job) => ["queued", "running", "paused"].includes(job.state),
  delete: (job) => FINAL.includes(job.state),
};

/** Return an empty badge. */
export const badge = () => h("span", { class: "state" });

/** Write a job's state on its badge. */
export function stamp(node, job) {
  node.className = `state ${job.state}`;
  put(node, job.wanted ? `${job.state}, to ${job.wanted}` : job.state);
}

/** Hold the buttons of one job; they stay the same ones, so that focus and a press outlive news of the job. */
export class Verbs {
  /**
   * @param {(job: object) => void} changed is told the job as it is after an answer
   * @param {HTMLElement} next takes the focus when the last button goes
   * @param {() => void} gone is called when the job has been deleted
   */
  constructor(changed, next, gone) {
    Object.assign(this, { changed, next, gone });
    this.buttons = Object.keys(CAN).map((verb) => h("button", { type: "button", onclick: () => this.ask(verb) }, verb));
    this.node = h("div", { class: "bar verbs" }, this.buttons);
  }

  show(job) {
    this.job = job;
    // Asked first: a button that is hidden has lost the focus.
    const held = this.buttons.find((button) => button === document.activeElement);
    Object.entries(CAN).forEach(([verb, can], k) => {
      this.buttons[k].hidden = !can(job);
      this.buttons[k].setAttribute("aria-label", `${verb} ${job.name}`);
    });
    this.node.hidden = this.buttons.every((button) => button.hidden);
    if (held?.hidden) (this.buttons.find((button) => !button.hidden) ?? this.next).focus();
  }

  async ask(verb) {
    // A button that is disabled would lose the focus.
    if (this.busy) return;
    this.busy = true;
    try {
      if (verb === "delete") await this.delete();
      else {
        this.changed(await post(`v1/jobs/${this.job.id}/${verb}`));
        tell(`${this.job.name}: ${verb} asked for`);
      }
    } catch (error) {
      report(error);
    }
    this.busy = false;
  }

  async delete() {
    const gone = await deleted([this.job]);
    if (!gone.length) return;
    // Its buttons go, and with them the focus.
    document.getElementById("page").focus();
    this.gone();
  }
}
