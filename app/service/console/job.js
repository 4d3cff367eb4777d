// Show one job: how far it is, its curves as they grow, a measured file over them, its knit, its figures, its files.
import { every, follow, get, report } from "./api.js";
import { Comparison } from "./compare.js";
import { Curves } from "./curves.js";
import { h, tell } from "./dom.js";
import { Figures } from "./figures.js";
import { Files, Log } from "./files.js";
import { Heading } from "./heading.js";
import { Shape } from "./shape.js";
import { FINAL } from "./states.js";

export async function showJob(place, signal, id, part) {
  let job = await get(`v1/jobs/${id}`, signal);
  const over = () => FINAL.includes(job.state);
  const heading = new Heading(place, job, changed, () => { location.hash = "#/"; });
  const curves = new Curves(signal);
  const shape = new Shape(id, signal, (section) => curves.measure(section));
  const comparison = new Comparison(id, signal);
  const files = new Files(id, signal), log = new Log(id, signal), figures = new Figures(id, signal);
  place.append(curves.node, comparison.node, shape.node, figures.node, h("div", { class: "two" }, files.node, log.node));

  function changed(now) {
    job = now;
    heading.show(job);
    curves.say(over());
    curves.mark(job.progress.crossings ?? []);
    comparison.node.hidden = !job.progress.rows;
  }

  /** Bring everything up to date that is not in the stream; what fails leaves the rest as it is. */
  async function settle() {
    const filed = async () => figures.look(await files.look(), job);
    const [wait] = await Promise.all([shape.look(job), filed(), log.look()].map((one) => one.catch(report)));
    return wait;
  }

  changed(job);
  follow(`v1/jobs/${id}/events`, (kind, data) => {
    if (kind === "rows") curves.add(data.rows);
    else if (kind === "progress") changed({ ...job, progress: data });
    else if (kind === "state") {
      const before = job.state;
      changed(data);
      if (job.state === before) return;
      tell(`${job.name}: ${job.state}`);
      if (over()) settle();
    }
  }, signal);
  every(signal, async () => {
    const last = over();
    const wait = await settle();
    if (part === "files") files.node.scrollIntoView();
    part = "";
    return last ? 0 : wait ?? 5000;
  });
  window.addEventListener("reached", settle, { signal });
}
