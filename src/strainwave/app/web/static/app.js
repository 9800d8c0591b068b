// The page: chooses a drive, shows a view of it, follows the sliders.
import { call, leave } from "/static/api.js";
import { BACK, FORTH, step, undoable } from "/static/history.js";
import { busy, jobOf, progressOf, stop, stopAll } from "/static/jobs.js";
import { readLog } from "/static/log.js";
import { answer, ask, button, byId, clear, dark, element, legends, recolour, signed } from "/static/plots.js";
import { build, hideGoals, showGoal } from "/static/sliders.js";
import { about, asked, FIRST, recall, remember, setAbout, state } from "/static/state.js";
import { take, VIEWS } from "/static/views.js";

const PATIENCE = 2000; // ms after which a newer value ends the request under way
let seeking = 0; // number of the latest search for goals
let began = 0, newer = false; // time of the request under way, and whether a newer value waits for its end
let typing = 0, resizing = 0; // timers

function showStatus(text, bad) {
  byId("status").textContent = text;
  byId("status").className = bad ? "bad" : "";
}

function showRemarks(remarks) {
  const items = remarks.filter(Boolean).map((text) => element("li", { textContent: signed(text) }));
  byId("remarks").replaceChildren(...(items.length ? [element("ul", {}, ...items)] : []));
}

// Do some work; what the server refuses, or a fault of the page, is shown as a sentence.
async function guarded(work, refused = (sentence) => showStatus(sentence, true)) {
  try {
    const found = await work();
    if (!byId("status").classList.contains("bad")) showStatus("");
    return found;
  } catch (error) {
    if (error.name !== "AbortError") refused(error.message);
    return undefined;
  }
}

// Show the present view of the drive; `answered` follows a value that changes, whose state is kept at its end.
async function show(answered) {
  seeking += 1;
  hideGoals();
  leave("goal");
  leave("beside");
  if (!answered) await keepState();
  showStatus("");
  let waiting = true;
  const slow = setTimeout(() => { showStatus("computing …"); byId("plots").classList.add("waiting"); }, 400);
  const looking = setInterval(async () => {
    const now = await call("/api/status").catch(() => ({}));
    if (waiting && now.compiling) showStatus(now.compiling);
  }, 1000);
  const remarks = await guarded(() => VIEWS[state.view].show(refresh, answered), (sentence) => {
    showStatus("");
    answer(sentence, false, true);
  });
  waiting = false;
  clearTimeout(slow);
  clearInterval(looking);
  byId("plots").classList.remove("waiting");
  byId("first")?.remove();
  if (remarks) showRemarks(remarks);
}

// After a pause: for one slider after another the value that meets the limit, until something changes.
async function seekGoals() {
  const mine = (seeking += 1), names = about?.parameters.map((p) => p.name) ?? [];
  if (state.view !== "response" || !names.includes("limit.oscillation") || byId("plots").classList.contains("stale")) return;
  for (const p of about.parameters.filter((one) => one.log && one.now !== null && !/^(speed|limit|gear)[.]/.test(one.name))) {
    const found = await call("/api/goal", { body: { state: asked(), name: p.name }, kind: "goal" }).catch(() => ({ value: null }));
    if (mine !== seeking) return;
    showGoal(p.name, found.value);
  }
}

// Follow a value that changes: one request is under way, and its answer is followed by that of the newest value.
async function refresh() {
  newer = Date.now() - began < PATIENCE;
  if (newer) return;
  const mine = (began = Date.now());
  let overtaken = false;
  const answered = () => {
    if (mine !== began) return overtaken;
    began = 0;
    overtaken = newer;
    if (newer) refresh();
    return overtaken;
  };
  await show(answered);
  if (!answered()) await keepState();
}

async function reload() {
  if (await load()) await show();
}

// A typed text is read by the server, which marks the field where it refuses it.
function readTyped() {
  clearTimeout(typing);
  typing = setTimeout(reload, 250);
}

async function keepState() {
  await remember();
  [byId("undo").disabled, byId("redo").disabled] = undoable().map((can) => !can);
}

// Take the drive before the last change, or after the one that was undone.
function undo(direction) {
  const drive = step(direction);
  if (drive === null) return;
  Object.assign(state, drive);
  reload();
}

const showTab = () => byId("views").scrollTo({ left: byId("tab-" + state.view).offsetLeft - byId("views").offsetLeft - 40 }); // the page itself stays

async function chooseView(view) {
  leave("view");
  if (view !== state.view) delete state.options.run;
  state.view = view in VIEWS ? view : "response";
  for (const tab of byId("views").children) {
    const here = tab.dataset.view === state.view;
    tab.setAttribute("aria-selected", String(here));
    tab.tabIndex = here ? 0 : -1;
  }
  showTab();
  document.body.dataset.view = state.view;
  byId("panel").setAttribute("aria-labelledby", "tab-" + state.view);
  clear();
  byId("controls").replaceChildren();
  answer("");
  showRemarks([]);
  await show();
}

// Whether the server takes the drive; null where a later change has overtaken the question.
async function load() {
  let taken = null;
  const found = await guarded(() => call("/api/project", { body: { state: asked() }, kind: "project" }), (sentence) => {
    taken = false;
    showStatus(sentence, true);
  });
  if (!found) return taken;
  byId("gear").value = state.project === null ? state.gear : state.values.gear ?? "";
  setAbout(found);
  byId("title").textContent = found.title;
  document.title = `${found.title} · strainwave`;
  build(found, refresh, readTyped);
  for (const name of Object.keys(found.unknown)) delete state.values[name];
  const left = Object.values(found.unknown);
  if (left.length) showStatus(`Not applied: ${left.join("; ")}`, true);
  return true;
}

// The drive and the view of the address, or the first one and a sentence where the address has none.
async function openAddress() {
  let wrong = await recall();
  byId("gear").value = state.project === null ? state.gear : "";
  const whole = await load();
  if (whole === null) return;
  if (!whole) {
    wrong = `${byId("status").textContent}. The page shows ${FIRST} instead.`;
    Object.assign(state, { gear: FIRST, project: null, values: {} });
    await load();
  }
  if (byId("status").className) wrong ||= byId("status").textContent;
  await chooseView(state.view);
  if (wrong) showStatus(wrong, true);
}

// Another gear in the same axis: load, loop, limit, speeds, damping and a changed motor stay. Its kinematic error is its own.
async function changeGear(gear) {
  if (state.project !== null) state.values.gear = gear;
  else {
    const stays = about.parameters.filter((p) => p.group !== "gear" && !/^excitation[.](accuracy|kinematic_error)/.test(p.name) && (p.name !== "motor.inertia" || p.name in state.values));
    const values = stays.map((p) => [p.name, state.values[p.name] ?? `${p.value} ${p.unit}`.trim()]);
    const assumed = stays.filter((p) => !(p.name in state.values) && about.sources[p.name] === "assumed").map((p) => [`sources.${p.name}`, "assumed"]);
    const words = Object.entries(state.values).filter(([name, text]) => name === "title" || !/^[-+−.\d]/.test(text));
    Object.assign(state, { gear, values: Object.fromEntries([...words, ...values, ...assumed]) });
  }
  await reload();
}

// A project file in place of the drive, or a sentence on why the server refuses it.
async function openProject(text) {
  const before = { project: state.project, values: state.values };
  Object.assign(state, { project: text, values: {}, options: {} });
  const whole = await load();
  if (whole) await chooseView(state.view === "log" ? "response" : state.view);
  else if (whole === false) {
    const wrong = byId("status").textContent;
    Object.assign(state, before);
    if (about === null) await openAddress();
    showStatus(wrong, true);
  }
}

function makeTabs() {
  const names = Object.keys(VIEWS);
  byId("views").append(...names.map((view) => {
    const tab = button("tab-" + view, VIEWS[view].name, () => chooseView(view));
    tab.dataset.view = view;
    tab.setAttribute("role", "tab");
    tab.setAttribute("aria-controls", "panel");
    return tab;
  }));
  byId("views").addEventListener("keydown", (event) => {
    const now = names.indexOf(state.view), last = names.length - 1;
    const at = { ArrowRight: now === last ? 0 : now + 1, ArrowLeft: now === 0 ? last : now - 1, Home: 0, End: last }[event.key];
    if (at === undefined) return;
    event.preventDefault();
    byId("views").children[at].focus();
    chooseView(names[at]);
  });
}

// Project files and logs that are dropped onto the page or chosen on it.
function acceptDrops() {
  const body = document.body;
  addEventListener("dragover", (event) => { event.preventDefault(); body.classList.add("dragged"); });
  addEventListener("dragleave", () => body.classList.remove("dragged"));
  addEventListener("drop", async (event) => {
    event.preventDefault();
    body.classList.remove("dragged");
    const file = event.dataTransfer.files[0];
    if (!file) return;
    if (/\.ya?ml$/i.test(file.name)) await openProject(await file.text());
    else ask("log", { file });
  });
  document.addEventListener("project", (event) => openProject(event.detail));
  document.addEventListener("log", async (event) => {
    showStatus("reading the log …");
    let wrong = "";
    await guarded(() => readLog(event.detail.file, event.detail.columns), (sentence) => { wrong = sentence; });
    if (state.view !== "log") await chooseView("log");
    else await show();
    if (wrong) answer(`${event.detail.file.name}: ${wrong}`, false);
  });
}

const menuGroup = (label, names) => element("optgroup", { label }, ...names.map((name) => element("option", { value: name, textContent: name })));

async function fillGears() {
  const gears = (await guarded(() => call("/api/gears"))) ?? [];
  const axes = (await guarded(() => call("/api/axes"))) ?? {};
  const own = element("option", { value: "", textContent: "own project", disabled: true });
  byId("gear").append(own, menuGroup("Axes to begin with", Object.keys(axes)), menuGroup("Gears", gears.map((gear) => gear.name)));
  byId("gear").addEventListener("change", ({ target: { value } }) => (value in axes ? openProject(axes[value]) : changeGear(value)));
}

function listenToHeader() {
  byId("rename").addEventListener("click", () => {
    const title = prompt("Title of the drive, of its files and of its report", about.title)?.trim();
    if (title) ask("values", { title });
  });
  byId("open").addEventListener("click", () => byId("project-file").click());
  byId("project-file").addEventListener("change", (event) => event.target.files[0]?.text().then(openProject));
  byId("reset").addEventListener("click", () => { state.values = {}; reload(); });
  byId("undo").addEventListener("click", () => undo(BACK));
  byId("redo").addEventListener("click", () => undo(FORTH));
  addEventListener("keydown", (event) => {
    const key = event.key.toLowerCase();
    const otherField = event.target.matches?.("input:is([type=text], [type=number])") && !event.target.closest("#sliders");
    if (!(event.ctrlKey || event.metaKey) || !["z", "y"].includes(key) || otherField) return; // that undoes its text itself
    event.preventDefault();
    undo(event.shiftKey || key === "y" ? FORTH : BACK);
  });
}

function listenToSaves() {
  for (const what of ["project", "script"]) byId("save-" + what).addEventListener("click", () => guarded(() => take(what)));
  byId("save-report").addEventListener("click", () => (busy("report") ? stop("report") : guarded(() => take("report"))));
  const menu = byId("save");
  addEventListener("click", ({ target }) => menu.contains(target) || menu.removeAttribute("open"));
  addEventListener("keydown", ({ key }) => {
    if (key !== "Escape" || !menu.open) return;
    menu.removeAttribute("open");
    menu.firstElementChild.focus();
  });
}

// The progress of a job: of the report in the header, of a view at its tab and in its picture.
async function showJob(name) {
  if (name === "report") {
    byId("save-report").textContent = busy(name) ? "Cancel report" : "Report";
    byId("report-stage").textContent = busy(name) ? progressOf(jobOf(name)) : "";
    return;
  }
  byId("tab-" + name).classList.toggle("busy", busy(name));
  if (name !== state.view) return;
  const remarks = await guarded(() => VIEWS[name].show(refresh));
  if (remarks) showRemarks(remarks);
}

// Add a part with its first values to the drive, or take away one that is present.
async function changePart({ values, present, id }) {
  const before = { ...state.values };
  for (const [name, value] of Object.entries(values)) {
    if (present) delete state.values[name];
    else state.values[name] = value;
  }
  const whole = await load();
  if (whole) await show();
  else if (whole === false) state.values = before;
  byId(id)?.focus();
}

function listenToPage() {
  document.addEventListener("job", ({ detail }) => showJob(detail));
  document.addEventListener("part", ({ detail }) => changePart(detail));
  document.addEventListener("values", ({ detail }) => { Object.assign(state.values, detail); reload(); });
  document.addEventListener("pause", seekGoals);
  byId("sliders").addEventListener("submit", (event) => event.preventDefault());
  dark.addEventListener("change", () => { recolour(); show(); });
  addEventListener("scroll", () => document.body.classList.toggle("scrolled", scrollY > 300), { passive: true });
  addEventListener("hashchange", openAddress);
  addEventListener("resize", () => {
    clearTimeout(resizing);
    resizing = setTimeout(() => { showTab(); legends(); }, 150);
  });
  addEventListener("pagehide", stopAll);
}

async function start() {
  makeTabs();
  acceptDrops();
  await fillGears();
  listenToHeader();
  listenToSaves();
  listenToPage();
  if (state.project === null) await openAddress(); // else one was dropped already
}

start();
