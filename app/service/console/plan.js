// Say what a protocol would do.
import { h, put } from "./dom.js";
import { sweepPlan } from "./sweep_plan.js";
import { AXES, percent, si, size, span } from "./words.js";

const MOST_STROKES = 200;

const lengths = (byAxis) => Object.entries(byAxis).map(([axis, length]) => `${AXES[axis]} ${si(length, "m")}`).join(", ");

function facts({ specimen, duration_s, rows, log_bytes, defaults }) {
  const pairs = {
    "Takes on the rig": span(duration_s),
    "Rows of the log": rows,
    "Files of the log": `${size(Math.round(log_bytes))} at most`,
    Specimen: `${specimen.nodes} nodes, yarn ${si(specimen.yarn_length_m, "m")}, narrowest gap ${si(specimen.clearance_m, "m")}`,
    "Hook to hook": lengths(specimen.gauge_lengths_m),
    "Locking strain": specimen.locking_strain ? percent(specimen.locking_strain) : "not estimated",
    "Taken by default": Object.entries(defaults).map(([place, text]) => `${place}: ${text}`).join(", ") || "nothing",
  };
  return h("dl", {}, Object.entries(pairs).map(([name, value]) => [h("dt", {}, name), h("dd", {}, value)]));
}

function table(strokes) {
  const shown = strokes.slice(0, MOST_STROKES);
  return [
    h("div", { class: "scroll strokes", tabindex: "0", role: "group", "aria-label": "Strokes" }, h("table", {},
      h("thead", {}, h("tr", {}, ["Cycle", "Stroke", "Tag", "To", "Takes"].map((name) => h("th", { scope: "col" }, name)))),
      h("tbody", {}, shown.map((stroke) => h("tr", {},
        [stroke.cycle, stroke.phase, stroke.tag ?? "", lengths(stroke.end_m), span(stroke.duration_s)].map((text) => h("td", {}, text))))))),
    strokes.length > shown.length && h("p", { class: "faint" }, `${strokes.length - shown.length} strokes more.`)];
}

/** Hold the plan of the last valid text, which says so once the text is another. */
export class Plan {
  constructor() {
    this.age = h("p", { class: "warning", hidden: true });
    this.body = h("div");
    this.node = h("div", {}, this.age, this.body);
  }

  /** Show the plan of one test; of a sweep its totals before that of its first test. */
  show(plan, sweep = null) {
    this.body.replaceChildren(sweep ? sweepPlan(sweep) : "", h("div", {}, plan.warnings.map((text) => h("p", { class: "warning" }, text)), facts(plan), table(plan.strokes)));
    this.age.hidden = true;
    this.body.className = "";
  }

  /** Say that the text is no longer the one that this is the plan of. */
  outdate() {
    if (!this.body.firstChild) return;
    put(this.age, "Of the last valid text, not of this one.");
    this.age.hidden = false;
    this.body.className = "stale";
  }
}
