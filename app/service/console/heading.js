// Say above all else how far a job is, and change that in place as it goes on.
import { report } from "./api.js";
import { Busy } from "./busy.js";
import { entitle, h, put, tell } from "./dom.js";
import { save } from "./files.js";
import { Verbs, badge, stamp } from "./verbs.js";
import { doing, ending, percent, span } from "./words.js";

export class Heading {
  constructor(place, job, changed, gone) {
    const title = h("h1", { tabindex: "-1" }, job.name, " ", h("span", { class: "faint" }, job.id));
    this.state = badge();
    this.verbs = new Verbs(changed, title, gone);
    this.report = h("button", { type: "button", onclick: () => this.take(job) }, "Report");
    this.busy = new Busy();
    const again = h("a", { class: "button", href: `#/new?job=${job.id}` }, "Edit and run again");
    this.done = h("progress", { max: 1, "aria-label": "done" });
    this.share = h("span");
    this.left = h("span", { class: "faint" });
    this.rows = h("span", { class: "faint" });
    this.where = h("p");
    this.beyond = h("div");
    const sweep = job.sweep && h("a", { href: `#/sweeps/${job.sweep}` }, `sweep ${job.sweep.slice(0, 8)}`);
    place.append(h("div", {},
      h("div", { class: "bar spread" }, title, h("div", { class: "bar" }, this.busy.node, this.state, again, this.report, this.verbs.node)),
      h("div", { class: "bar" }, this.done, this.share, this.left, this.rows, sweep),
      this.where, this.beyond));
  }

  /** Save the report: it is drawn when it is asked for, which takes some seconds. */
  async take({ id, name }) {
    if (this.taking) return;
    this.taking = true;
    try {
      await this.busy.during("Making the report", () => save(`v1/jobs/${id}/report`, `${name}_report.html`));
      tell(`${name}: the report is saved`);
    } catch (error) {
      report(error);
    }
    this.taking = false;
  }

  show(job) {
    const { progress } = job;
    stamp(this.state, job);
    this.verbs.show(job);
    this.report.hidden = !progress.rows;
    this.done.value = progress.share;
    put(this.share, percent(progress.share, 0));
    this.left.hidden = Boolean(job.finished);
    put(this.left, `${span(progress.seconds_left)} left`);
    put(this.rows, `${progress.rows} equilibria, attempt ${job.attempts}`);
    put(this.where, job.finished ? ending(job) : doing(progress));
    const said = (events, words) => (events ?? []).map(({ text }) => `${words}: ${text}.`);
    const texts = [...said(progress.crossings, "Beyond strength"), ...said(progress.losses, "Let go")];
    if (texts.join() !== this.texts) this.beyond.replaceChildren(...texts.map((text) => h("p", { class: "warning" }, text)));
    this.texts = texts.join();
    entitle(job.finished ? `${job.name} ${job.state}` : `${percent(progress.share, 0)} ${job.name}`);
  }
}
