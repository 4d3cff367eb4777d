// Ask for the service's token, in the page: once, however many requests wait for it.

const KEPT = "knitlab-token";
let asked = null;

/** Return the token that was given, if any. */
export const token = () => sessionStorage.getItem(KEPT);

function question(refused) {
  const form = document.getElementById("token");
  const input = form.querySelector("input");
  form.querySelector("[role=alert]").textContent = refused ? "The last one was refused." : "";
  form.hidden = false;
  // Whoever is at work elsewhere in the page is not torn away.
  if ([document.body, document.getElementById("page")].includes(document.activeElement)) input.focus();
  return new Promise((resolve) => {
    form.onsubmit = (event) => {
      event.preventDefault();
      sessionStorage.setItem(KEPT, input.value.trim());
      form.reset();
      form.hidden = true;
      resolve();
    };
  });
}

/** Come back when there is another token than the one that was refused. */
export async function otherToken(refused) {
  if (token() !== refused) return;
  asked ??= question(refused).finally(() => { asked = null; });
  await asked;
}
