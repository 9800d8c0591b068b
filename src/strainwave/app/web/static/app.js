// The page: chooses a drive, shows a view of it, follows the sliders.
import { call, leave } from "/static/api.js";
import { clear, dark, element, legends } from "/static/plots.js";
import { build } from "/static/sliders.js";
import { asked, recall, remember, state } from "/static/state.js";
import { forget, readLog, repaint, setProject, stop, take, VIEWS } from "/static/views.js";

const byId = (id) => document.getElementById(id);
let timer = 0, resizing = 0;

function say(text, bad) {
  byId("status").textContent = text;
  byId("status").className = bad ? "bad" : "";
}

function remark(remarks) {
  const items = remarks.filter(Boolean).map((text) => element("li", { textContent: text }));
  byId("remarks").replaceChildren(...(items.length ? [element("ul", {}, ...items)] : []));
}

async function trying(work) {
  try {
    const found = await work();
    say("");
    return found;
  } catch (error) {
    if (error.name !== "AbortError") say(error.message, true);
    return undefined;
  }
}

async function show() {
  await remember();
  let waiting = true;
  const slow = setTimeout(() => say("computing …"), 400);
  const looking = setInterval(async () => {
    const now = await call("/api/status").catch(() => ({}));
    if (waiting && now.compiling) say(now.compiling);
  }, 1000);
  const remarks = await trying(() => VIEWS[state.view].show(soon));
  waiting = false;
  clearTimeout(slow);
  clearInterval(looking);
  byId("first")?.remove();
  if (remarks) remark(remarks);
}

function soon() {
  clearTimeout(timer);
  timer = setTimeout(show, 25);
}

const showTab = () => byId("tab-" + state.view).scrollIntoView({ block: "nearest", inline: "nearest" });

async function choose(view) {
  leave("view");
  await stop();
  if (view !== state.view) delete state.options.run;
  state.view = view in VIEWS ? view : "response";
  for (const tab of byId("views").children) {
    const here = tab.dataset.view === state.view;
    tab.setAttribute("aria-selected", String(here));
    tab.tabIndex = here ? 0 : -1;
  }
  showTab();
  byId("panel").setAttribute("aria-labelledby", "tab-" + state.view);
  forget();
  clear();
  byId("controls").replaceChildren();
  byId("answer").textContent = "";
  remark([]);
  await show();
}

async function load() {
  byId("gear").value = state.project === null ? state.gear : "";
  const found = await trying(() => call("/api/project", { body: { state: asked() }, kind: "project" }));
  if (!found) return false;
  setProject(found);
  byId("title").textContent = found.title;
  document.title = `${found.title} · strainwave`;
  build(found, soon);
  return true;
}

async function taken(text) {
  state.project = text;
  Object.assign(state, { values: {}, options: {} });
  if (await load()) await choose(state.view === "log" ? "response" : state.view);
}

function tabs() {
  const names = Object.keys(VIEWS);
  byId("views").append(...names.map((view) => {
    const tab = element("button", { type: "button", id: "tab-" + view, textContent: VIEWS[view].name });
    tab.dataset.view = view;
    tab.setAttribute("role", "tab");
    tab.setAttribute("aria-controls", "panel");
    tab.addEventListener("click", () => choose(view));
    return tab;
  }));
  byId("views").addEventListener("keydown", (event) => {
    const now = names.indexOf(state.view), last = names.length - 1;
    const at = { ArrowRight: now === last ? 0 : now + 1, ArrowLeft: now === 0 ? last : now - 1, Home: 0, End: last }[event.key];
    if (at === undefined) return;
    event.preventDefault();
    byId("views").children[at].focus();
    choose(names[at]);
  });
}

function dropping() {
  const body = document.body;
  addEventListener("dragover", (event) => { event.preventDefault(); body.classList.add("dragged"); });
  addEventListener("dragleave", () => body.classList.remove("dragged"));
  addEventListener("drop", async (event) => {
    event.preventDefault();
    body.classList.remove("dragged");
    const file = event.dataTransfer.files[0];
    if (!file) return;
    if (/\.ya?ml$/i.test(file.name)) await taken(await file.text());
    else document.dispatchEvent(new CustomEvent("log", { detail: file }));
  });
  document.addEventListener("project", (event) => taken(event.detail));
  document.addEventListener("log", async (event) => {
    if (state.view !== "log") await choose("log");
    forget();
    clear();
    const notes = await trying(() => readLog(event.detail));
    if (notes) remark(notes);
  });
}

async function begin() {
  tabs();
  dropping();
  await recall();
  const gears = (await trying(() => call("/api/gears"))) ?? [];
  byId("gear").append(element("option", { value: "", textContent: "own project", disabled: true }));
  byId("gear").append(...gears.map((gear) => element("option", { value: gear.name, textContent: gear.name })));
  byId("gear").addEventListener("change", async () => {
    Object.assign(state, { gear: byId("gear").value, project: null, values: {}, options: {} });
    if (await load()) await choose(state.view);
  });
  byId("open").addEventListener("click", () => byId("project-file").click());
  byId("project-file").addEventListener("change", (event) => event.target.files[0]?.text().then(taken));
  byId("reset").addEventListener("click", async () => { state.values = {}; if (await load()) await show(); });
  for (const what of ["project", "script", "report"]) {
    byId("save-" + what).addEventListener("click", () => trying(() => take(what)));
  }
  document.addEventListener("part", async ({ detail: { values, present, id } }) => {
    const before = { ...state.values };
    for (const [name, value] of Object.entries(values)) {
      if (present) delete state.values[name];
      else state.values[name] = value;
    }
    if (await load()) await show();
    else state.values = before;
    byId(id)?.focus();
  });
  byId("sliders").addEventListener("submit", (event) => event.preventDefault());
  dark.addEventListener("change", async () => { if (!(await repaint())) await choose(state.view); });
  addEventListener("hashchange", async () => { await recall(); if (await load()) await choose(state.view); });
  addEventListener("resize", () => {
    clearTimeout(resizing);
    resizing = setTimeout(() => { showTab(); legends(); }, 150);
  });
  addEventListener("pagehide", stop);
  if (await load()) await choose(state.view);
}

begin();
