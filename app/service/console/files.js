// Show what a job has written: its files to take away, and its log to read.
import { ask, get, report } from "./api.js";
import { Busy } from "./busy.js";
import { arrange, h, put } from "./dom.js";
import { size } from "./words.js";

/** Save an answer as a file; a link cannot carry the token. */
export async function save(path, name) {
  saveBlob(await (await ask(path)).blob(), name);
}

/** Save what the page made as a file. */
export function saveBlob(blob, name) {
  const link = h("a", { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

/** Hold the table of a job's files; a file keeps its line while it grows. */
export class Files {
  constructor(job, signal) {
    Object.assign(this, { job, signal, lines: new Map() });
    this.busy = new Busy();
    this.none = h("p", { class: "faint" }, "No files.");
    this.body = h("tbody");
    this.table = h("div", { class: "scroll", hidden: true }, h("table", {},
      h("thead", {}, h("tr", {}, h("th", { scope: "col" }, "File"), h("th", { scope: "col" }, "Kind"), h("th", { scope: "col", class: "number" }, "Size"))),
      this.body));
    this.node = h("section", {}, h("div", { class: "bar spread" }, h("h2", {}, "Files"), this.busy.node), this.none, this.table);
  }

  line({ name, kind }) {
    const path = `v1/jobs/${this.job}/files/${name}`;
    const plain = name.split("/").at(-1);
    const take = (event) => { event.preventDefault(); this.busy.during(`Fetching ${plain}`, () => save(path, plain)).catch(report); };
    return h("tr", {},
      h("td", { class: "name" }, h("a", { href: path, download: plain, onclick: take }, name)), h("td", {}, kind), h("td", { class: "number" }));
  }

  async look() {
    const { files } = await get(`v1/jobs/${this.job}/files`, this.signal);
    for (const file of files) {
      if (!this.lines.has(file.name)) this.lines.set(file.name, this.line(file));
      put(this.lines.get(file.name).lastChild, size(file.size));
    }
    arrange(this.body, files.map(({ name }) => this.lines.get(name)));
    this.none.hidden = files.length > 0;
    this.table.hidden = !files.length;
    return files;
  }
}

/** Hold the log of a job; it stays where it was scrolled to, or at its end. */
export class Log {
  constructor(job, signal) {
    Object.assign(this, { job, signal });
    this.text = h("pre", { tabindex: "0", "aria-label": "Log of the job", hidden: true });
    this.none = h("p", { class: "faint" }, "Nothing is written.");
    this.node = h("section", {}, h("h2", {}, "Log of the job"), this.none, this.text);
  }

  async look() {
    let found = "";
    try {
      found = await (await ask(`v1/jobs/${this.job}/files/job.log`, { signal: this.signal })).text();
    } catch (error) {
      if (error.problem?.status !== 404) throw error;
    }
    const { scrollTop, scrollHeight, clientHeight } = this.text;
    put(this.text, found);
    this.text.hidden = !found;
    this.none.hidden = Boolean(found);
    this.text.scrollTop = scrollTop + clientHeight >= scrollHeight - 2 ? this.text.scrollHeight : scrollTop;
  }
}
