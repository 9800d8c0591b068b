// The state of the page: gear or project text, changed values, view. The address holds all of it.

export const FIRST = "CSG-40-50";
const PAUSE = 700; // ms without a change, after which the next change is one of its own for Back and Undo
export const state = { gear: FIRST, project: null, values: {}, view: "response", options: {} };

export let about = null; // what the server says of the drive: its numbers and its speeds
export const setAbout = (found) => { about = found; };
export const stem = () => (about?.title ?? "drive").replace(/[^\w.-]+/g, "-").slice(0, 60); // of the names of files

const bytesOf = async (stream) => new Uint8Array(await new Response(stream).arrayBuffer());

async function packed(text) {
  const zipped = await bytesOf(new Blob([text]).stream().pipeThrough(new CompressionStream("deflate-raw")));
  let plain = "";
  for (const byte of zipped) plain += String.fromCharCode(byte);
  return btoa(plain).replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
}

async function unpacked(text) {
  const plain = atob(text.replaceAll("-", "+").replaceAll("_", "/"));
  const zipped = Uint8Array.from(plain, (c) => c.charCodeAt(0));
  const bytes = await bytesOf(new Blob([zipped]).stream().pipeThrough(new DecompressionStream("deflate-raw")));
  return new TextDecoder().decode(bytes);
}

const past = [], future = [];
export let session = []; // actions since the drive was opened: changed values, view and its options
let opened = "";

function note() {
  const { gear, project, values, view, options } = state, from = String(project ?? gear);
  if (opened !== from) session = [];
  opened = from;
  const last = session.at(-1), action = { values: { ...values }, view, options: { ...options } };
  if (last && last.view === view && (!pausing || JSON.stringify(last.values) === JSON.stringify(values))) session.pop();
  session.push(action);
}

let drive = null, pausing = true, timer = 0;
const driveNow = () => JSON.stringify({ gear: state.gear, project: state.project, values: state.values });

// Write the state into the address: a new entry of the history after a pause, else the one that the change began.
export async function remember() {
  const query = new URLSearchParams();
  if (state.project === null) query.set("gear", state.gear);
  else query.set("project", await packed(state.project));
  query.set("view", state.view);
  for (const [name, value] of Object.entries(state.values)) query.set("v." + name, value);
  for (const [name, value] of Object.entries(state.options)) query.set("o." + name, value);
  const hash = "#" + query, now = driveNow(), began = pausing && drive !== null;
  note();
  if (now !== drive && began) {
    past.push(drive);
    future.length = 0;
  }
  if (hash !== location.hash || now !== drive) pausing = false;
  if (hash !== location.hash) history[began ? "pushState" : "replaceState"](null, "", hash);
  drive = now;
  clearTimeout(timer);
  timer = setTimeout(pause, PAUSE);
}

function pause() {
  pausing = true;
  document.dispatchEvent(new Event("pause"));
}

export const undoable = () => [past.length > 0, future.length > 0];

// Take the drive before the last change, or after the one that was undone; whether there is one.
export function step([from, to]) {
  if (!from.length) return false;
  to.push(drive);
  drive = from.pop();
  Object.assign(state, JSON.parse(drive));
  pausing = true;
  return true;
}
export const BACK = [past, future], FORTH = [future, past];

// Read the state from the address; a sentence where it is damaged.
export async function recall() {
  const query = new URLSearchParams(location.hash.slice(1));
  Object.assign(state, { gear: query.get("gear") ?? FIRST, project: null, values: {}, options: {} });
  state.view = query.get("view") ?? "response";
  pausing = true;
  try {
    if (query.has("project")) state.project = await unpacked(query.get("project"));
  } catch {
    return `The link is damaged: its project cannot be read. The page shows ${FIRST} instead; copy the whole link, or open the project file.`;
  }
  for (const [key, value] of query) {
    if (key.startsWith("v.")) state.values[key.slice(2)] = value;
    if (key.startsWith("o.")) state.options[key.slice(2)] = value;
  }
  return "";
}

export function asked() {
  const which = state.project === null ? { gear: state.gear } : { project: state.project };
  return { ...which, values: state.values };
}
