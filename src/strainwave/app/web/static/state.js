// The state of the page: gear or project text, changed values, view. The address holds all of it.

export const state = { gear: "CSG-40-50", project: null, values: {}, view: "response", options: {} };

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

export async function remember() {
  const query = new URLSearchParams();
  if (state.project === null) query.set("gear", state.gear);
  else query.set("project", await packed(state.project));
  query.set("view", state.view);
  for (const [name, value] of Object.entries(state.values)) query.set("v." + name, value);
  for (const [name, value] of Object.entries(state.options)) query.set("o." + name, value);
  history.replaceState(null, "", "#" + query);
}

export async function recall() {
  const query = new URLSearchParams(location.hash.slice(1));
  if (query.has("gear")) Object.assign(state, { gear: query.get("gear"), project: null });
  if (query.has("project")) {
    try { state.project = await unpacked(query.get("project")); } catch { state.project = null; }
  }
  state.view = query.get("view") ?? "response";
  state.values = {};
  state.options = {};
  for (const [key, value] of query) {
    if (key.startsWith("v.")) state.values[key.slice(2)] = value;
    if (key.startsWith("o.")) state.options[key.slice(2)] = value;
  }
}

export function asked() {
  const drive = state.project === null ? { gear: state.gear } : { project: state.project };
  return { ...drive, values: state.values };
}
