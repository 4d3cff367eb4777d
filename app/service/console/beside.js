// Files that go with a protocol: centrelines and tables, added from a disk, pasted, or brought by an example.
import { h, put, tell } from "./dom.js";
import { size } from "./words.js";

const DRAFT = "knitlab-draft-files";
const MOST_BYTES = 1e6;
const HINT = "For a protocol that names a CSV file, a centreline (`knit: {centreline: my-knit.csv, …}`) or a table: they are sent with it. A YAML file is taken as the materials.";

/** One file: its name, its text, and what is wrong with it. */
class Row {
  constructor(name, text, { changed, remove }) {
    this.name = h("input", { type: "text", size: 18, maxlength: 200, required: true, "aria-label": "Name of the file", oninput: changed });
    this.name.value = name;
    this.size = h("span", { class: "faint" });
    this.area = h("textarea", { rows: 6, spellcheck: "false", "aria-label": "Text of the file", oninput: () => { this.measure(); changed(); } });
    this.area.value = text;
    this.wrong = h("p", { class: "wrong", hidden: true });
    const away = h("button", { type: "button", onclick: () => remove(this) }, "Remove");
    this.node = h("li", {}, h("div", { class: "bar" }, this.name, this.size, away), this.area, this.wrong);
    this.measure();
  }

  measure() {
    put(this.size, size(new Blob([this.area.value]).size));
  }

  /** Say what is wrong with it, line by line. */
  mark(places, twice) {
    const said = places.map(({ line, column, detail }) => `line ${line}, column ${column}: ${detail}`);
    if (twice) said.push("Another file has this name: the last one counts.");
    this.wrong.hidden = !said.length;
    put(this.wrong, said.join("\n"));
    this.area.setAttribute("aria-invalid", String(places.length > 0));
  }
}

export class Beside {
  /** @param {object} parts `changed()` after a change, `materials(text)` takes a file of materials */
  constructor({ changed, materials }) {
    Object.assign(this, { rows: [], told: changed, materials });
    const choose = h("input", { type: "file", multiple: true, accept: ".csv,.yaml,.yml,text/csv", hidden: true, onchange: () => this.take([...choose.files]).then(() => { choose.value = ""; }) });
    this.count = h("span", { class: "faint" });
    this.list = h("ul", { class: "beside" });
    this.node = h("details", {}, h("summary", {}, "Files ", this.count), h("p", { class: "faint" }, HINT), this.list,
      h("div", { class: "bar" }, choose,
        h("button", { type: "button", onclick: () => choose.click() }, "Add files …"),
        h("button", { type: "button", onclick: () => this.paste() }, "Paste one")));
    this.restore();
  }

  /** Return the texts by name; of two of one name the last counts. */
  get texts() {
    return Object.fromEntries(this.rows.map(({ name, area }) => [name.value.trim(), area.value]));
  }

  get names() {
    return Object.keys(this.texts);
  }

  restore() {
    let kept = {};
    try {
      kept = JSON.parse(localStorage.getItem(DRAFT) ?? "{}");
    } catch {
      localStorage.removeItem(DRAFT);
    }
    for (const [name, text] of Object.entries(kept)) this.insert(name, String(text));
    this.node.open = this.rows.length > 0;
  }

  changed() {
    put(this.count, this.rows.length ? `(${this.rows.length})` : "");
    try {
      localStorage.setItem(DRAFT, JSON.stringify(this.texts));
    } catch {
      tell("the files are too large for this browser to keep as a draft");
    }
    this.told();
  }

  insert(name, text) {
    const row = new Row(name, text, { changed: () => this.changed(), remove: (gone) => this.remove(gone) });
    this.rows.push(row);
    this.list.append(row.node);
    put(this.count, `(${this.rows.length})`);
    return row;
  }

  remove(row) {
    const place = this.rows.indexOf(row);
    this.rows.splice(place, 1);
    row.node.remove();
    // The focus goes to what is nearest, not back to the top of the page.
    (this.rows[place] ?? this.rows[place - 1])?.name.focus();
    if (!this.rows.length) this.node.querySelector("summary").focus();
    this.changed();
  }

  /** Put files in the place of those of the same names. */
  put(texts) {
    for (const [name, text] of Object.entries(texts)) {
      const row = this.rows.find((one) => one.name.value.trim() === name);
      if (row) row.area.value = text;
      else this.insert(name, text);
      row?.measure();
    }
    if (Object.keys(texts).length) this.node.open = true;
    this.changed();
  }

  /** Have these files and no others. */
  replace(texts) {
    for (const { node } of this.rows.splice(0)) node.remove();
    this.put(texts);
  }

  paste() {
    const free = Array.from({ length: this.rows.length + 1 }, (_, k) => `my-knit${k ? `-${k + 1}` : ""}.csv`).find((name) => !this.names.includes(name));
    const row = this.insert(free, "");
    this.changed();
    row.area.focus();
  }

  /** Take files of a disk. */
  async take(files) {
    const texts = {};
    for (const file of files) {
      if (file.size > MOST_BYTES) tell(`${file.name}: found ${file.size} bytes, allowed ${MOST_BYTES} or fewer`);
      else if (/\.ya?ml$/i.test(file.name)) this.materials(await file.text());
      else texts[file.name] = await file.text();
    }
    this.put(texts);
  }

  /** Say what is wrong in each file. */
  mark(places) {
    const names = this.rows.map(({ name }) => name.value.trim());
    this.rows.forEach((row, k) => row.mark(places.filter(({ file }) => file === names[k]), names.indexOf(names[k]) !== names.lastIndexOf(names[k])));
    if (places.some(({ file }) => names.includes(file))) this.node.open = true;
  }
}
