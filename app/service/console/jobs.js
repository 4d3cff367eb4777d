// List the jobs, newest first, and keep the list fresh.
import { get, post } from "./api.js";
import { AXES, h, percent, si, span, tell } from "./dom.js";

const STATES = ["queued", "running", "paused", "cancelling", "succeeded", "failed", "cancelled"];
const PERIOD = 2000;

/** Return the buttons for what can be asked of a job. */
export function actions(job, changed) {
  const asked = {
    pause: ["queued", "running"].includes(job.state) && !job.wanted,
    resume: job.state === "paused",
    cancel: ["queued", "running", "paused"].includes(job.state),
  };
  return Object.entries(asked).filter(([, can]) => can).map(([verb]) =>
    h("button", {
      type: "button",
      "aria-label": `${verb} ${job.name}`,
      onclick: async (event) => {
        event.target.disabled = true;
        try {
          changed(await post(`v1/jobs/${job.id}/${verb}`));
          tell(`${job.name}: ${verb} asked for`);
        } catch (error) {
          tell(error.message);
          event.target.disabled = false;
        }
      },
    }, verb));
}

/** Return a job's state as a badge. */
export const badge = (job) => h("span", { class: `state ${job.state}` }, job.wanted ? `${job.state}, to ${job.wanted}` : job.state);

/** Say where a job is: strains and forces of its axes. */
export const whereabouts = ({ strain, force }) =>
  Object.keys(strain).map((axis) => `${AXES[axis]} ${percent(strain[axis])}, ${si(force[axis], "N")}`).join("; ");

function line(job, refresh) {
  const { progress } = job;
  return h("tr", { "data-job": job.id },
    h("td", {}, h("a", { href: `#/jobs/${job.id}` }, job.name), " ", h("span", { class: "faint" }, job.id.slice(0, 8))),
    h("td", {}, badge(job)),
    h("td", {}, h("progress", { max: 1, value: progress.share, "aria-label": `${job.name} done` }), ` ${percent(progress.share, 0)}`),
    h("td", {}, job.end ? `ended by ${job.end}` : whereabouts(progress)),
    h("td", { class: "number" }, job.finished ? "" : span(progress.seconds_left)),
    h("td", {}, new Date(job.created).toLocaleString()),
    h("td", { class: "bar" }, actions(job, refresh)));
}

export async function showJobs(page, signal) {
  let cursors = [null];
  const filter = h("select", { id: "state", onchange: () => { cursors = [null]; refresh(); } },
    h("option", { value: "" }, "all"), STATES.map((state) => h("option", { value: state }, state)));
  const body = h("tbody");
  const newer = h("button", { type: "button", onclick: () => { cursors.pop(); refresh(); } }, "Newer");
  const older = h("button", { type: "button", onclick: () => { cursors.push(older.dataset.cursor); refresh(); } }, "Older");
  const empty = h("p", { class: "faint", hidden: true }, "No jobs here. ", h("a", { href: "#/new" }, "Begin a test"), ".");
  page.append(
    h("div", { class: "bar spread" }, h("h1", {}, "Jobs"), h("label", { class: "faint" }, "State ", filter)),
    h("section", { class: "scroll" },
      h("table", {},
        h("thead", {}, h("tr", {}, ["Test", "State", "Done", "Where it is", "Left", "Submitted", "Ask"].map((name) =>
          h("th", { scope: "col", class: name === "Left" ? "number" : null }, name)))),
        body),
      empty,
      h("div", { class: "bar" }, newer, older)));

  let shown = "";
  async function refresh() {
    const query = new URLSearchParams({ limit: "25" });
    if (filter.value) query.set("state", filter.value);
    if (cursors.at(-1)) query.set("cursor", cursors.at(-1));
    const found = await get(`v1/jobs?${query}`);
    newer.hidden = cursors.length === 1;
    older.hidden = !found.cursor;
    older.dataset.cursor = found.cursor ?? "";
    empty.hidden = found.jobs.length > 0;
    // Lines are laid anew only when something changed, so that a button under the keyboard's focus stays.
    const now = JSON.stringify(found.jobs);
    if (now !== shown) body.replaceChildren(...found.jobs.map((job) => line(job, refresh)));
    shown = now;
  }
  await refresh();
  const timer = setInterval(() => refresh().catch((error) => tell(error.message)), PERIOD);
  signal.addEventListener("abort", () => clearInterval(timer));
}
