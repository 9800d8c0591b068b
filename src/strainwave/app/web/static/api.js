// Requests to the server. Of one kind only the latest goes on.

const going = new Map();

// Nobody waits for the answer of this kind any more.
export function leave(kind) {
  going.get(kind)?.abort();
  going.delete(kind);
}

export async function call(path, { body, method, kind, raw, signal } = {}) {
  if (kind) {
    going.get(kind)?.abort();
    const abort = new AbortController();
    going.set(kind, abort);
    signal = abort.signal;
  }
  const options = { method: method ?? (body === undefined && raw === undefined ? "GET" : "POST"), signal };
  if (raw !== undefined) options.body = raw;
  else if (body !== undefined) {
    options.body = JSON.stringify(body);
    options.headers = { "content-type": "application/json" };
  }
  let answer;
  try {
    answer = await fetch(path, options);
  } catch (error) {
    if (error.name === "AbortError") throw error;
    throw new Error("the server does not answer; is strainwave app still running?");
  }
  const text = await answer.text();
  const isJson = answer.headers.get("content-type")?.startsWith("application/json");
  const content = isJson ? JSON.parse(text) : text;
  if (!answer.ok) throw new Error(content.error ?? `the server answers ${answer.status}`);
  return content;
}

export function download(name, content, type) {
  const url = URL.createObjectURL(content instanceof Blob ? content : new Blob([content], { type }));
  const link = Object.assign(document.createElement("a"), { href: url, download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(url), 1000);
}
