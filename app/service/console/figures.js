// Show in the page what a job has drawn and come to: its plots and pictures, its figures, its report.
import { ask, get, report } from "./api.js";
import { Busy } from "./busy.js";
import { arrange, h, put } from "./dom.js";
import { figure } from "./words.js";

const MOST_PICTURES = 12;
const MOST_BYTES = 20e6;

/** Hold one picture; it is fetched again once its file has another size. */
class Picture {
  constructor(job, name, signal) {
    Object.assign(this, { path: `v1/jobs/${job}/files/${name}`, signal, size: 0 });
    const plain = name.split("/").at(-1);
    this.image = h("img", { alt: plain.replace(/\.png$/, "").replaceAll("_", " ") });
    this.whole = h("a", { target: "_blank", rel: "noopener", "aria-label": `${plain} in a window of its own` }, this.image);
    this.node = h("figure", {}, this.whole, h("figcaption", { class: "faint" }, plain));
    signal.addEventListener("abort", () => URL.revokeObjectURL(this.image.src));
  }

  /** Fetch the picture; a link cannot carry the token. */
  async show(size) {
    if (size === this.size) return;
    this.size = size;
    const found = await (await ask(this.path, { signal: this.signal })).blob();
    URL.revokeObjectURL(this.image.src);
    this.image.src = this.whole.href = URL.createObjectURL(found);
  }
}

/** Hold the plots and pictures, the figures and the report of a job. */
export class Figures {
  constructor(job, signal) {
    Object.assign(this, { job, signal, pictures: new Map() });
    this.none = h("p", { class: "faint" }, "Plots and pictures come when the test has ended.");
    this.gallery = h("div", { class: "gallery" });
    this.rows = h("tbody");
    this.table = h("details", { hidden: true }, h("summary", {}, "Figures of the test"), h("div", { class: "scroll strokes", tabindex: "0", role: "group", "aria-label": "Figures of the test" }, h("table", {},
      h("thead", {}, h("tr", {}, h("th", { scope: "col" }, "Figure"), h("th", { scope: "col", class: "number" }, "Value"))), this.rows)));
    this.busy = new Busy();
    this.read = h("button", { type: "button", hidden: true, "aria-expanded": "false", onclick: () => this.toggle().catch(report) }, "Read the report here");
    this.frame = h("div", { class: "report" });
    this.node = h("section", {}, h("h2", {}, "Figures"), this.none, this.gallery, this.table, h("div", { class: "bar" }, this.read, this.busy.node), this.frame);
  }

  /** Take up the files and state of the job. */
  async look(files, { finished, progress }) {
    this.read.hidden = !progress.rows;
    const found = files.filter(({ name, size }) => name.endsWith(".png") && size < MOST_BYTES).slice(0, MOST_PICTURES);
    for (const { name } of found) if (!this.pictures.has(name)) this.pictures.set(name, new Picture(this.job, name, this.signal));
    arrange(this.gallery, found.map(({ name }) => this.pictures.get(name).node));
    this.none.hidden = found.length > 0;
    if (finished) put(this.none, "No plots or pictures were drawn.");
    await Promise.all(found.map(({ name, size }) => this.pictures.get(name).show(size)));
    if (finished && this.table.hidden && files.some(({ name }) => name === "figures.json")) await this.tell();
  }

  async tell() {
    const { figures } = await get(`v1/jobs/${this.job}/figures`, this.signal);
    this.rows.replaceChildren(...figures.map(({ name, value, unit }) => h("tr", {}, h("td", {}, name), h("td", { class: "number" }, figure(value, unit)))));
    this.table.hidden = !figures.length;
  }

  /** Show the report in a frame that may do nothing, or close it; it is made when it is asked for. */
  async toggle() {
    if (this.making) return;
    if (this.frame.firstChild) this.frame.replaceChildren();
    else {
      this.making = true;
      try {
        const page = await this.busy.during("Making the report", async () => (await ask(`v1/jobs/${this.job}/report`, { signal: this.signal })).text());
        this.frame.replaceChildren(h("iframe", { sandbox: "", srcdoc: page, title: "Report of the job" }));
      } finally {
        this.making = false;
      }
    }
    const open = Boolean(this.frame.firstChild);
    this.read.setAttribute("aria-expanded", String(open));
    put(this.read, open ? "Close the report" : "Read the report here");
  }
}
