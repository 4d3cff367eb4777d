// Ask before jobs are deleted, and say what would be lost.
import { get, remove, report } from "./api.js";
import { h, put, tell } from "./dom.js";
import { FINAL } from "./states.js";
import { size } from "./words.js";

const MOST_NAMES = 8;
const MOST_LOOKS = 50;
const KINDS = { record: "what was recorded, from which all else is made", log: "logs of the instrument", picture: "plots and pictures", text: "texts" };

/** Return in words what files hold. */
function lost(files) {
  const kinds = Object.keys(KINDS).filter((kind) => files.some((file) => file.kind === kind));
  const whole = files.reduce((sum, file) => sum + file.size, 0);
  const count = `${files.length} ${files.length === 1 ? "file" : "files"}, ${size(whole)}`;
  return kinds.length ? `${count}: ${kinds.map((kind) => KINDS[kind]).join(", ")}.` : "No files yet.";
}

async function filesOf(jobs) {
  const found = await Promise.all(jobs.slice(0, MOST_LOOKS).map(({ id }) => get(`v1/jobs/${id}/files`)));
  return found.flatMap(({ files }) => files);
}

/** Ask in the page whether to delete jobs that have ended; an answer of the keyboard is one too, Escape keeps them. */
function confirmed(jobs) {
  const [one] = jobs;
  const title = jobs.length === 1 ? `Delete ${one.name} (${one.id.slice(0, 8)})?` : `Delete ${jobs.length} jobs?`;
  const names = jobs.slice(0, MOST_NAMES).map(({ name, id }) => `${name} (${id.slice(0, 8)})`).join(", ");
  const more = jobs.length > MOST_NAMES ? ` and ${jobs.length - MOST_NAMES} more` : "";
  const what = h("p", {}, "Looking what there is …");
  const box = h("dialog", { "aria-label": title },
    h("h2", {}, title), jobs.length > 1 && h("p", {}, `${names}${more}.`), what,
    h("p", {}, `This cannot be taken back; ${jobs.length === 1 ? "the protocol goes" : "the protocols go"} too.`),
    h("form", { method: "dialog", class: "bar" },
      h("button", { value: "keep", autofocus: true }, "Keep"), h("button", { value: "delete", class: "danger" }, "Delete")));
  document.body.append(box);
  filesOf(jobs).then((files) => put(what, `Lost for good: ${lost(files)}${jobs.length > MOST_LOOKS ? ` (Of the first ${MOST_LOOKS}.)` : ""}`))
    .catch(() => put(what, "Lost for good: all files."));
  return new Promise((resolve) => {
    box.addEventListener("close", () => {
      box.remove();
      resolve(box.returnValue === "delete");
    });
    box.showModal();
  });
}

/** Delete jobs one by one, and note those that are gone; a service that is away ends it. */
async function each(jobs, gone, told) {
  for (const { id, name } of jobs) {
    told(`Deleting ${name}`, gone.length / jobs.length);
    try {
      await remove(`v1/jobs/${id}`);
      gone.push(id);
    } catch (error) {
      report(error);
      if (!error.problem) return;
    }
  }
}

/** Delete jobs once that is confirmed; return the ids of those that are gone. */
export async function deleted(jobs, busy = null) {
  const ended = jobs.filter(({ state }) => FINAL.includes(state));
  if (!ended.length) {
    tell("None of these has ended; press cancel first.");
    return [];
  }
  if (!(await confirmed(ended))) return [];
  const gone = [];
  const work = (told) => each(ended, gone, told);
  await (busy ? busy.during("Deleting", work) : work(() => {}));
  const kept = jobs.length - ended.length;
  const left = kept ? `; ${kept} not ended, kept` : "";
  const what = gone.length === 1 ? ended.find(({ id }) => id === gone[0]).name : `${gone.length} jobs`;
  if (gone.length) tell(`${what}: deleted${left}`);
  return gone;
}
