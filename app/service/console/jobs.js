// List the jobs, newest first, by state and sweep, and keep the list fresh.
import { every, get, report } from "./api.js";
import { Choice, forget } from "./choice.js";
import { arrange, entitle, h, put } from "./dom.js";
import { Line } from "./line.js";
import { rest } from "./reach.js";
import { STATES } from "./states.js";

const PERIOD = 2000;
const PAGE = 25;
const COLUMNS = ["Choose", "Test", "State", "Done", "Where it is", "Left", "Submitted", "Ask"];

class List {
  constructor(place, signal, query) {
    Object.assign(this, { signal, state: query.get("state") ?? "", sweep: query.get("sweep") ?? "" });
    this.cursors = [null];
    this.lines = new Map();
    this.turn = 0;
    this.body = h("tbody");
    this.which = h("span", { class: "faint" });
    this.newer = h("button", { type: "button", onclick: () => this.go(() => this.cursors.pop()) }, "Newer");
    this.older = h("button", { type: "button", onclick: () => this.go(() => this.cursors.push(this.next)) }, "Older");
    this.empty = h("p", { class: "faint", hidden: true }, "No jobs here. ", h("a", { href: "#/new" }, "Begin a test"), ".");
    this.choice = new Choice(() => [...this.lines.values()].map(({ box }) => box), () => this.refresh().catch(report));
    this.states = new Map(["", ...STATES].map((state) => [state, this.stateLink(state)]));
    place.append(
      h("div", { class: "bar spread" }, h("h1", {}, "Jobs"), h("nav", { class: "bar", "aria-label": "State" }, ...this.states.values())),
      this.sweep ? h("p", { class: "bar" }, `Sweep ${this.sweep} alone.`, h("a", { href: `#/sweeps/${this.sweep}` }, "Its table and plot"),
        h("a", { href: `#/${this.state && `?state=${this.state}`}` }, "Show all jobs")) : "",
      h("section", {},
        this.choice.node,
        h("div", { class: "scroll" }, h("table", {},
          h("thead", {}, h("tr", {}, COLUMNS.map((name) => h("th", { scope: "col", class: name === "Left" ? "number" : null }, name)))),
          this.body)),
        this.empty,
        h("div", { class: "bar" }, this.newer, this.older, this.which)));
  }

  /** Return the link to the jobs of one state, or of all. */
  stateLink(state) {
    const query = new URLSearchParams({ ...(state && { state }), ...(this.sweep && { sweep: this.sweep }) });
    return h("a", { href: `#/?${query}`, "aria-current": state === this.state && "true" }, state || "all");
  }

  go(turn) {
    turn();
    this.refresh().catch(report);
  }

  async refresh() {
    const turn = (this.turn += 1);
    const query = new URLSearchParams({ limit: PAGE });
    if (this.state) query.set("state", this.state);
    if (this.sweep) query.set("sweep", this.sweep);
    if (this.cursors.at(-1)) query.set("cursor", this.cursors.at(-1));
    const found = await get(`v1/jobs?${query}`, this.signal);
    // Another page was asked for meanwhile.
    if (turn !== this.turn) return;
    this.next = found.cursor;
    this.show(found.jobs);
    this.count(found);
  }

  show(jobs) {
    const changed = (now) => this.lines.get(now.id)?.show(now);
    const gone = (id) => { forget(id); this.choice.show(); this.refresh().catch(report); };
    const chosen = () => this.choice.show();
    const lines = new Map(jobs.map((job) => [job.id, this.lines.get(job.id) ?? new Line(job, changed, () => gone(job.id), chosen)]));
    this.choice.refresh(jobs);
    this.lines = lines;
    for (const job of jobs) lines.get(job.id).show(job);
    arrange(this.body, [...lines.values()].map(({ row }) => row));
    this.empty.hidden = jobs.length > 0;
  }

  /** Say how many jobs there are, in each state and on this page. */
  count({ jobs, cursor, counts }) {
    const counted = { ...counts, "": Object.values(counts).reduce((sum, one) => sum + one, 0) };
    for (const [state, link] of this.states) {
      put(link, `${state || "all"} ${counted[state]}`);
      link.hidden = Boolean(state) && state !== this.state && !counted[state];
    }
    const before = PAGE * (this.cursors.length - 1);
    put(this.which, jobs.length ? `${before + 1}–${before + jobs.length} of ${counted[this.state]}` : "");
    this.newer.hidden = this.cursors.length === 1;
    this.older.hidden = !cursor;
  }
}

export async function showJobs(place, signal, query) {
  entitle("Jobs");
  const list = new List(place, signal, query);
  await list.refresh();
  rest(PERIOD).then(() => every(signal, async () => {
    await list.refresh();
    return PERIOD;
  }));
}
