// Whether the server answers.  After a failure, tries again until it does.
import { admin, kindOf, textOf, useToken } from "./api.js";
import { byId } from "./dom.js";

const alertBox = byId("alert"),
  chip = byId("server"),
  chipText = byId("server-text");
const tokenForm = /** @type {HTMLFormElement} */ (byId("token-form"));
const tokenInput = /** @type {HTMLInputElement} */ (byId("token"));

/** @type {"connecting" | "ready" | "lost" | "token"} */
let state = "connecting";
/** @type {import("../../generated/lucerna/v1/admin_pb.js").Limits | undefined} */
export let limits;
/** @type {() => void} */
let onReady = () => {};

function show(/** @type {typeof state} */ next, /** @type {string} */ text) {
  state = next;
  chip.dataset.state = next;
  chipText.textContent = text;
  tokenForm.hidden = next !== "token";
}

/** Asks the server who it is.  Calls `onReady` if it answers. */
async function connect(wait = 500) {
  try {
    const info = await admin.getServerInfo({}, { timeoutMs: 10_000 });
    limits = info.limits;
    alertBox.hidden = true;
    show("ready", `lucernad ${info.version}, ${info.threads} threads`);
    onReady();
  } catch (error) {
    if (kindOf(error) === "token") return askToken(error);
    alertBox.textContent = `${textOf(error)} The page tries again until it answers.`;
    alertBox.hidden = false;
    show("lost", "no answer");
    setTimeout(() => connect(Math.min(2 * wait, 4000)), wait);
  }
}

function askToken(/** @type {unknown} */ error) {
  alertBox.hidden = true;
  byId("token-error").textContent = tokenInput.value ? textOf(error) : "";
  show("token", "token needed");
  tokenInput.focus();
}

/** Starts the session.  `ready` is called now, and again after each failure that is over. */
export function startSession(/** @type {() => void} */ ready) {
  onReady = ready;
  tokenForm.addEventListener("submit", (event) => {
    event.preventDefault();
    useToken(tokenInput.value);
    connect();
  });
  connect();
}

/**
 * Takes an error that concerns the whole session: true if it does, so that the caller need not show it.  Cancelled
 * calls concern nobody.
 */
export function handled(/** @type {unknown} */ error) {
  const kind = kindOf(error);
  if (kind === "cancelled") return true;
  if (kind === "token") {
    if (state !== "token") askToken(error);
    return true;
  }
  if (kind !== "lost") return false;
  if (state === "ready") {
    show("lost", "no answer");
    alertBox.textContent = `${textOf(error)} The page tries again until it answers.`;
    alertBox.hidden = false;
    setTimeout(connect, 500);
  }
  return true;
}
