// The page: chooses a drive, shows a view of it, follows the sliders.
import { call, leave } from "/static/api.js";
import { busy, jobOf, progressOf, stop, stopAll } from "/static/jobs.js";
import { readLog } from "/static/log.js";
import { answer, ask, button, byId, clear, dark, element, legends, recolour, signed } from "/static/plots.js";
import { build, hideGoals, showGoal } from "/static/sliders.js";
import { about, asked, BACK, FIRST, FORTH, recall, remember, setAbout, state, step, undoable } from "/static/state.js";
import { take, VIEWS } from "/static/views.js";

const PATIENCE = 2000; // ms after which a newer value ends the request under way
let seeking = 0, began = 0, newer = false, typing = 0, resizing = 0;

function say(text, bad) {
  byId("status").textContent = text;
  byId("status").className = bad ? "bad" : "";
}

function remark(remarks) {
  const items = remarks.filter(Boolean).map((text) => element("li", { textContent: signed(text) }));
  byId("remarks").replaceChildren(...(items.length ? [element("ul", {}, ...items)] : []));
}

async function trying(work, refused = (sentence) => say(sentence, true)) {
  try {
    const found = await work();
    if (!byId("status").classList.contains("bad")) say("");
    return found;
  } catch (error) {
    if (error.name !== "AbortError") refused(error.message);
    return undefined;
  }
}

async function show(answered) {
  seeking += 1;
  hideGoals();
  leave("goal");
  leave("beside");
  if (!answered) await keep();
  say("");
  let waiting = true;
  const slow = setTimeout(() => { say("computing …"); byId("plots").classList.add("waiting"); }, 400);
  const looking = setInterval(async () => {
    const now = await call("/api/status").catch(() => ({}));
    if (waiting && now.compiling) say(now.compiling);
  }, 1000);
  const remarks = await trying(() => VIEWS[state.view].show(soon, answered), (sentence) => {
    say("");
    answer(sentence, false, true);
  });
  waiting = false;
  clearTimeout(slow);
  clearInterval(looking);
  byId("plots").classList.remove("waiting");
  byId("first")?.remove();
  if (remarks) remark(remarks);
}

// After a pause: for one slider after another the value that meets the limit, until something changes.
async function seek() {
  const mine = (seeking += 1), names = about?.parameters.map((p) => p.name) ?? [];
  if (state.view !== "response" || !names.includes("limit.oscillation") || byId("plots").classList.contains("stale")) return;
  for (const p of about.parameters.filter((one) => one.log && one.now !== null && !/^(speed|limit|gear)[.]/.test(one.name))) {
    const found = await call("/api/goal", { body: { state: asked(), name: p.name }, kind: "goal" }).catch(() => ({ value: null }));
    if (mine !== seeking) return;
    showGoal(p.name, found.value);
  }
}

// Follow a value that changes: one request is under way, and its answer is followed by that of the newest value.
async function soon() {
  newer = Date.now() - began < PATIENCE;
  if (newer) return;
  const mine = (began = Date.now());
  let overtaken = false;
  const answered = () => {
    if (mine !== began) return overtaken;
    began = 0;
    overtaken = newer;
    if (newer) soon();
    return overtaken;
  };
  await show(answered);
  if (!answered()) await keep();
}

async function again() {
  if (await load()) await show();
}

// A typed text is read by the server, which marks the field where it refuses it.
function typed() {
  clearTimeout(typing);
  typing = setTimeout(again, 250);
}

async function keep() {
  await remember();
  [byId("undo").disabled, byId("redo").disabled] = undoable().map((can) => !can);
}

const turned = (way) => step(way) && again();

const showTab = () => byId("views").scrollTo({ left: byId("tab-" + state.view).offsetLeft - byId("views").offsetLeft - 40 }); // the page itself stays

async function choose(view) {
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
  remark([]);
  await show();
}

// Whether the server takes the drive; null where a later change has overtaken the question.
async function load() {
  let taken = null;
  const found = await trying(() => call("/api/project", { body: { state: asked() }, kind: "project" }), (sentence) => {
    taken = false;
    say(sentence, true);
  });
  if (!found) return taken;
  byId("gear").value = state.project === null ? state.gear : state.values.gear ?? "";
  setAbout(found);
  byId("title").textContent = found.title;
  document.title = `${found.title} · strainwave`;
  build(found, soon, typed);
  for (const name of Object.keys(found.unknown)) delete state.values[name];
  const left = Object.values(found.unknown);
  if (left.length) say(`Left out: ${left.join("; ")}`, true);
  return true;
}

// The drive and the view of the address, or the first one and a sentence where the address has none.
async function opened() {
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
  await choose(state.view);
  if (wrong) say(wrong, true);
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
  await again();
}

async function taken(text) {
  const before = { project: state.project, values: state.values };
  Object.assign(state, { project: text, values: {}, options: {} });
  const whole = await load();
  if (whole) await choose(state.view === "log" ? "response" : state.view);
  else if (whole === false) {
    const wrong = byId("status").textContent;
    Object.assign(state, before);
    if (about === null) await opened();
    say(wrong, true);
  }
}

function tabs() {
  const names = Object.keys(VIEWS);
  byId("views").append(...names.map((view) => {
    const tab = button("tab-" + view, VIEWS[view].name, () => choose(view));
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
    else ask("log", { file });
  });
  document.addEventListener("project", (event) => taken(event.detail));
  document.addEventListener("log", async (event) => {
    say("reading the log …");
    let wrong = "";
    await trying(() => readLog(event.detail.file, event.detail.columns), (sentence) => { wrong = sentence; });
    if (state.view !== "log") await choose("log");
    else await show();
    if (wrong) answer(`${event.detail.file.name}: ${wrong}`, false);
  });
}

async function begin() {
  tabs();
  dropping();
  const gears = (await trying(() => call("/api/gears"))) ?? [];
  const axes = (await trying(() => call("/api/axes"))) ?? {};
  byId("gear").append(element("option", { value: "", textContent: "own project", disabled: true }));
  byId("gear").append(element("optgroup", { label: "Axes to begin with" }, ...Object.keys(axes).map((name) => element("option", { value: name, textContent: name }))));
  byId("gear").append(element("optgroup", { label: "Gears" }, ...gears.map((gear) => element("option", { value: gear.name, textContent: gear.name }))));
  byId("gear").addEventListener("change", ({ target: { value } }) => (value in axes ? taken(axes[value]) : changeGear(value)));
  byId("rename").addEventListener("click", () => {
    const title = prompt("Title of the drive, of its files and of its report", about.title)?.trim();
    if (title) ask("values", { title });
  });
  byId("undo").addEventListener("click", () => turned(BACK));
  byId("redo").addEventListener("click", () => turned(FORTH));
  addEventListener("keydown", (event) => {
    const key = event.key.toLowerCase(), other = event.target.matches?.("input:is([type=text], [type=number])") && !event.target.closest("#sliders");
    if (!(event.ctrlKey || event.metaKey) || !["z", "y"].includes(key) || other) return; // another field undoes its text itself
    event.preventDefault();
    turned(event.shiftKey || key === "y" ? FORTH : BACK);
  });
  byId("open").addEventListener("click", () => byId("project-file").click());
  byId("project-file").addEventListener("change", (event) => event.target.files[0]?.text().then(taken));
  byId("reset").addEventListener("click", () => { state.values = {}; again(); });
  for (const what of ["project", "script"]) byId("save-" + what).addEventListener("click", () => trying(() => take(what)));
  byId("save-report").addEventListener("click", () => (busy("report") ? stop("report") : trying(() => take("report"))));
  const menu = byId("save");
  addEventListener("click", ({ target }) => menu.contains(target) || menu.removeAttribute("open"));
  addEventListener("keydown", ({ key }) => key === "Escape" && menu.open && [menu.removeAttribute("open"), menu.firstElementChild.focus()]);
  document.addEventListener("job", ({ detail: name }) => {
    if (name === "report") {
      byId("save-report").textContent = busy(name) ? "Cancel report" : "Report";
      byId("report-stage").textContent = busy(name) ? progressOf(jobOf(name)) : "";
    } else {
      byId("tab-" + name).classList.toggle("busy", busy(name));
      if (name === state.view) trying(() => VIEWS[name].show(soon)).then((remarks) => remarks && remark(remarks));
    }
  });
  document.addEventListener("part", async ({ detail: { values, present, id } }) => {
    const before = { ...state.values };
    for (const [name, value] of Object.entries(values)) {
      if (present) delete state.values[name];
      else state.values[name] = value;
    }
    const whole = await load();
    if (whole) await show();
    else if (whole === false) state.values = before;
    byId(id)?.focus();
  });
  document.addEventListener("pause", seek);
  addEventListener("scroll", () => document.body.classList.toggle("scrolled", scrollY > 300), { passive: true });
  document.addEventListener("values", ({ detail }) => { Object.assign(state.values, detail); again(); });
  byId("sliders").addEventListener("submit", (event) => event.preventDefault());
  dark.addEventListener("change", () => { recolour(); show(); });
  addEventListener("hashchange", opened);
  addEventListener("resize", () => {
    clearTimeout(resizing);
    resizing = setTimeout(() => { showTab(); legends(); }, 150);
  });
  addEventListener("pagehide", stopAll);
  if (state.project === null) await opened(); // else one was dropped already
}

begin();
