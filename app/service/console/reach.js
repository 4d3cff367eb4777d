// Say as long as the service cannot be reached, and tell the pages (`reached`) when it can again.

const PERIOD = 1000;
let away = false;

const show = () => { document.getElementById("away").hidden = !away; };

/** Wait some milliseconds. */
export const rest = (time) => new Promise((resolve) => { setTimeout(resolve, time); });

/** Note that the service answered. */
export function found() {
  if (!away) return;
  away = false;
  show();
  window.dispatchEvent(new Event("reached"));
}

/** Note that the service did not answer; it is tried until it does. */
export async function lost() {
  if (away) return;
  away = true;
  show();
  while (away) {
    await rest(PERIOD);
    const answer = await fetch("healthz", { cache: "no-store" }).catch(() => null);
    if (answer?.ok) found();
  }
}
