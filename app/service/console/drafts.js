// Keep what is being written, and what was written before another protocol took its place.

const KEYS = { protocol: "knitlab-draft", materials: "knitlab-draft-materials" };
const BEFORE = "knitlab-draft-before";

/** Return the texts that were kept; a text is null where there is none. */
export const kept = () => Object.fromEntries(Object.entries(KEYS).map(([name, key]) => [name, localStorage.getItem(key)]));

/** Keep texts as the draft. */
export function keep(texts) {
  for (const [name, key] of Object.entries(KEYS)) localStorage.setItem(key, texts[name]);
}

/** Return the draft that another protocol took the place of, if there is one. */
export const before = () => JSON.parse(localStorage.getItem(BEFORE));

/** Keep a draft beside the present one, or forget it. */
export function setBefore(texts) {
  if (texts) localStorage.setItem(BEFORE, JSON.stringify(texts));
  else localStorage.removeItem(BEFORE);
}
