// Speak REST with the service that this page came from.
import { tell } from "./dom.js";
import { found, lost, rest } from "./reach.js";
import { inPage } from "./remedies.js";
import { otherToken, token } from "./token.js";

/** An error that the service answered with. */
export class Problem extends Error {
  constructor(answer) {
    const problem = inPage(answer);
    super(problem.detail ?? problem.title ?? "the service gave no reason");
    this.problem = problem;
  }
}

/** No answer at all. */
export class Unreachable extends Error {
  constructor() {
    super("the service cannot be reached");
  }
}

const PAUSE = 2000;
// What stands in front of a service answers so while the service is down.
const GATEWAY = [502, 503, 504];

async function answered(path, options) {
  const given = token();
  const headers = { ...options.headers, ...(given && { Authorization: `Bearer ${given}` }) };
  let response;
  try {
    response = await fetch(path, { ...options, headers });
  } catch (error) {
    if (error.name === "AbortError") throw error;
    lost();
    throw new Unreachable();
  }
  const written = (response.headers.get("content-type") ?? "").includes("json");
  if (GATEWAY.includes(response.status) && !written) {
    lost();
    throw new Unreachable();
  }
  found();
  return { response, written, given };
}

/** Ask, and return the response; an error of the service becomes a `Problem`. */
export async function ask(path, options = {}) {
  for (;;) {
    const { response, written, given } = await answered(path, options);
    if (response.ok) return response;
    if (response.status !== 401) {
      throw new Problem(written ? await response.json() : { detail: `${response.status} ${response.statusText}` });
    }
    await otherToken(given);
    options.signal?.throwIfAborted();
  }
}

export const get = async (path, signal) => (await ask(path, { signal })).json();
export const post = async (path) => (await ask(path, { method: "POST" })).json();

export const remove = (path) => ask(path, { method: "DELETE" });

/** Send a protocol's text, and those of its materials file and of other files where there are any; routes of sweeps take JSON alone. */
export function sendProtocol(path, { protocol, materials, files = {} }, { headers = {}, signal, asJson = false } = {}) {
  const beside = { ...(materials.trim() && { materials }), ...(Object.keys(files).length && { files }) };
  const [kind, body] = asJson || Object.keys(beside).length
    ? ["application/json", JSON.stringify({ protocol, ...beside })]
    : ["application/yaml", protocol];
  return ask(path, { method: "POST", body, signal, headers: { "Content-Type": kind, ...headers } });
}

/** Tell of an error, unless the page was left or the standing notice says it already. */
export function report(error) {
  if (error.name !== "AbortError" && !(error instanceof Unreachable)) tell(error.message);
}

/** Do something again and again until the page is left; it returns how long to rest [ms], or nothing to end. */
export async function every(signal, act) {
  while (!signal.aborted) {
    let pause = PAUSE;
    try {
      pause = await act();
    } catch (error) {
      report(error);
    }
    if (!pause) return;
    await rest(pause);
  }
}

/** Hand out the events in a response's body, each as its fields. */
async function* events(response) {
  const reader = response.body.pipeThrough(new TextDecoderStream()).getReader();
  let tail = "";
  for (;;) {
    const { value, done } = await reader.read();
    if (done) return;
    const parts = (tail + value).split("\n\n");
    tail = parts.pop();
    for (const part of parts) yield Object.fromEntries(part.split("\n").map((line) => line.split(/: (.*)/s).slice(0, 2)));
  }
}

/** Follow server-sent events to their end; comes back after a cut with the id of the last one seen. */
export async function follow(path, handle, signal) {
  let last = "";
  await every(signal, async () => {
    try {
      const response = await ask(path, { signal, headers: last ? { "Last-Event-ID": last } : {} });
      if (response.status === 204) return 0;
      for await (const { id, event, data } of events(response)) {
        if (id) last = id;
        if (data) handle(event, JSON.parse(data));
      }
    } catch (error) {
      // A stream that is cut, or one too many of them, is tried again without a word.
      if (error instanceof Problem && error.problem.status === 404) {
        report(error);
        return 0;
      }
    }
    return PAUSE;
  });
}
