// Show one job as a line of the list, and change the line in place as the job goes on.
import { box } from "./choice.js";
import { h, put } from "./dom.js";
import { Verbs, badge, stamp } from "./verbs.js";
import { doing, ended, percent, span } from "./words.js";

export class Line {
  /**
   * @param {(job: object) => void} changed is told the job as it is after an answer
   * @param {() => void} gone is called when the job has been deleted
   * @param {() => void} chosen is called when the job was chosen, or no longer is
   */
  constructor(job, changed, gone, chosen) {
    this.link = h("a", { href: `#/jobs/${job.id}` }, job.name);
    this.state = badge();
    this.done = h("progress", { max: 1, "aria-label": `${job.name} done` });
    this.share = h("span", { class: "whole" });
    this.where = h("td", { class: "where" });
    this.left = h("td", { class: "number" });
    this.verbs = new Verbs(changed, this.link, gone);
    this.box = box(job, chosen);
    const sweep = job.sweep && h("a", { class: "sweep", href: `#/sweeps/${job.sweep}` }, `sweep ${job.sweep.slice(0, 8)}`);
    this.row = h("tr", { "data-job": job.id },
      h("td", { class: "box" }, this.box),
      h("td", { class: "name" }, this.link, " ", h("span", { class: "faint" }, job.id.slice(0, 8)), sweep && [" ", sweep]),
      h("td", {}, this.state),
      h("td", {}, h("div", { class: "done" }, this.done, this.share)),
      this.where,
      this.left,
      h("td", {}, new Date(job.created).toLocaleString()),
      h("td", {}, this.verbs.node));
    this.show(job);
  }

  show(job) {
    const { progress } = job;
    stamp(this.state, job);
    this.done.value = progress.share;
    put(this.share, percent(progress.share, 0));
    put(this.where, job.finished ? ended(job) : doing(progress));
    put(this.left, job.finished ? "" : span(progress.seconds_left));
    this.verbs.show(job);
  }
}
