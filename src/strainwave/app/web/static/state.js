// The state of the page: gear or project text, changed values, view. The address holds all of it.
import { noteChange, settle } from "/static/history.js";

export const FIRST = "CSG-40-50";
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

// Write the state into the address: a new entry of the browser's history after a pause, else the one that the change began.
export async function remember() {
  const query = new URLSearchParams();
  if (state.project === null) query.set("gear", state.gear);
  else query.set("project", await packed(state.project));
  query.set("view", state.view);
  for (const [name, value] of Object.entries(state.values)) query.set("v." + name, value);
  for (const [name, value] of Object.entries(state.options)) query.set("o." + name, value);
  const hash = "#" + query, moved = hash !== location.hash, begins = noteChange(state, moved);
  if (moved) history[begins ? "pushState" : "replaceState"](null, "", hash);
}

// Read the state from the address; a sentence where it is damaged.
export async function recall() {
  const query = new URLSearchParams(location.hash.slice(1));
  Object.assign(state, { gear: query.get("gear") ?? FIRST, project: null, values: {}, options: {} });
  state.view = query.get("view") ?? "response";
  settle();
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
