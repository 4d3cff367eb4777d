// Show one job: how far it is, its curves as they grow, its knit, its files.
import { ask, follow, get } from "./api.js";
import { actions, badge, whereabouts } from "./jobs.js";
import { Curves } from "./curves.js";
import { h, percent, span, tell } from "./dom.js";
import { Knit } from "./knit.js";

const FINAL = ["succeeded", "failed", "cancelled"];

/** Save an answer as a file; a link cannot carry the token. */
async function save(path, name) {
  const found = await (await ask(path)).blob();
  const link = h("a", { href: URL.createObjectURL(found), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

function heading(host, job, changed) {
  const { progress } = job;
  const ended = job.finished ? h("p", {}, job.end ? `Ended by ${job.end}. ` : "", job.message) : h("p", {}, progress.text, " ", whereabouts(progress));
  host.replaceChildren(
    h("div", { class: "bar spread" },
      h("h1", {}, job.name, " ", h("span", { class: "faint" }, job.id)),
      h("div", { class: "bar" }, badge(job), actions(job, changed))),
    h("div", { class: "bar" },
      h("progress", { max: 1, value: progress.share, "aria-label": "done" }),
      h("span", {}, percent(progress.share, 0)),
      job.finished ? null : h("span", { class: "faint" }, `${span(progress.seconds_left)} left`),
      h("span", { class: "faint" }, `${progress.rows} equilibria, attempt ${job.attempts}`)),
    ended);
}

async function listFiles(host, job) {
  const { files } = await get(`v1/jobs/${job.id}/files`);
  const size = (bytes) => (bytes < 1e5 ? `${(bytes / 1e3).toFixed(1)} kB` : `${(bytes / 1e6).toFixed(1)} MB`);
  host.replaceChildren(h("h2", {}, "Files"),
    files.length === 0 ? h("p", { class: "faint" }, "None yet.") : h("div", { class: "scroll" }, h("table", {},
      h("thead", {}, h("tr", {}, h("th", { scope: "col" }, "File"), h("th", { scope: "col" }, "Kind"), h("th", { scope: "col", class: "number" }, "Size"))),
      h("tbody", {}, files.map((file) => h("tr", {},
        h("td", {}, h("a", {
          href: `v1/jobs/${job.id}/files/${file.name}`, download: file.name.split("/").at(-1),
          onclick: (event) => { event.preventDefault(); save(event.target.getAttribute("href"), event.target.download).catch((error) => tell(error.message)); },
        }, file.name)),
        h("td", {}, file.kind), h("td", { class: "number" }, size(file.size))))))));
}

async function showLog(host, job) {
  const text = await ask(`v1/jobs/${job.id}/files/job.log`).then((found) => found.text()).catch(() => "");
  host.replaceChildren(h("h2", {}, "Log of the job"), text ? h("pre", { tabindex: "0" }, text) : h("p", { class: "faint" }, "Nothing yet."));
}

export async function showJob(page, id, signal) {
  let job = await get(`v1/jobs/${id}`);
  const top = h("div"), charts = h("section"), shape = h("section"), files = h("section"), log = h("section");
  const none = h("p", { class: "faint" }, "No shape is recorded yet.");
  charts.append(h("h2", {}, "Curves"));
  shape.append(h("h2", {}, "Knit"), none);
  page.append(top, charts, shape, h("div", { class: "two" }, files, log));
  const curves = new Curves(charts, signal);
  let knit = null;

  const changed = (now) => { job = now; heading(top, job, changed); };

  async function look() {
    let index;
    try {
      index = await get(`v1/jobs/${id}/frames`);
    } catch (error) {
      if (error.problem?.status === 409) return;
      throw error;
    }
    if (!curves.section) curves.measure(index.section);
    if (!index.frames.length) return;
    if (knit) {
      knit.extend(index);
    } else {
      none.remove();
      knit = new Knit(shape, id, index, signal);
      await knit.go(0);
    }
  }

  async function settle() {
    await Promise.all([look(), listFiles(files, job), showLog(log, job)]);
  }

  changed(job);
  await settle();
  const timer = setInterval(() => { if (!FINAL.includes(job.state)) settle().catch((error) => tell(error.message)); }, 5000);
  signal.addEventListener("abort", () => clearInterval(timer));
  follow(`v1/jobs/${id}/events`, (kind, data) => {
    if (kind === "rows") curves.add(data.rows);
    else if (kind === "progress") changed({ ...job, progress: data });
    else if (kind === "state") {
      changed(data);
      tell(`${job.name}: ${job.state}`);
      if (FINAL.includes(job.state)) settle().catch((error) => tell(error.message));
    }
  }, signal).catch((error) => tell(error.message));
}
