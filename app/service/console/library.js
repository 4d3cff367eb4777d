// Choose one of the examples that are shipped.
import { get, report } from "./api.js";
import { h } from "./dom.js";

const FIRST = "First tests";

const address = (path) => `v1/examples/${path.split("/").map(encodeURIComponent).join("/")}`;

export class Library {
  /** @param {(example: object) => void} load takes the texts of the one that was chosen */
  constructor(load, signal) {
    Object.assign(this, { load, signal });
    this.filter = h("input", { type: "text", "aria-label": "Filter the examples", placeholder: "rib, rupture, volumetric …", oninput: () => this.narrow() });
    this.list = h("div", { class: "examples" });
    this.none = h("p", { class: "faint", role: "status" });
    this.node = h("dialog", { class: "library", "aria-labelledby": "library-title" },
      h("div", { class: "bar spread" }, h("h2", { id: "library-title" }, "Examples"),
        h("button", { type: "button", onclick: () => this.node.close() }, "Close")),
      this.filter, this.list, this.none);
  }

  async open() {
    try {
      if (!this.list.firstChild) this.fill((await get("v1/examples", this.signal)).examples);
    } catch (error) {
      report(error);
      return;
    }
    this.filter.value = "";
    this.narrow();
    this.node.showModal();
    this.filter.focus();
  }

  fill(examples) {
    this.groups = [...new Set(examples.map(({ group }) => group))].map((group) => {
      const entries = examples.filter((one) => one.group === group).map((one) => this.entry(one));
      const node = h("section", {}, h("h3", {}, group || FIRST), h("ul", {}, entries.map((entry) => entry.node)));
      return { node, entries };
    });
    this.list.append(...this.groups.map(({ node }) => node));
  }

  entry({ path, title, purpose, rig }) {
    const button = h("button", { type: "button", onclick: () => this.choose(path) },
      h("b", {}, title), h("span", { class: "faint" }, rig), h("span", { class: "purpose" }, purpose));
    return { node: h("li", {}, button), words: `${path} ${title} ${purpose} ${rig}`.toLowerCase() };
  }

  /** Show the examples that have all the words. */
  narrow() {
    const words = this.filter.value.toLowerCase().split(/\s+/);
    let shown = 0;
    for (const { node, entries } of this.groups) {
      for (const entry of entries) entry.node.hidden = !words.every((word) => entry.words.includes(word));
      const found = entries.filter((entry) => !entry.node.hidden).length;
      node.hidden = found === 0;
      shown += found;
    }
    this.none.textContent = shown ? "" : "No example has these words.";
  }

  async choose(path) {
    try {
      const example = await get(address(path), this.signal);
      this.node.close();
      this.load(example);
    } catch (error) {
      report(error);
    }
  }
}
