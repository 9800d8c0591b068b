// Sliders and fields, made from the description that the server gives of a project's numbers.
import { ask, button, byId, element, signed } from "/static/plots.js";
import { state } from "/static/state.js";

const STEPS = 1000; // positions of a slider
const short = (value, digits = 4) => Number(value.toPrecision(digits)).toString();
const ends = (p, value) => (p.log ? [p.low, p.high] : [Math.min(p.low, value), Math.max(p.high, value)]);

// Position of a value on its slider, and the value at a position; both by ratios where the slider is logarithmic.
const place = (p, value) => {
  const [low, high] = ends(p, value);
  const share = p.log ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
  return Math.round(STEPS * Math.min(1, Math.max(0, share)));
};
const valueAt = (p, at) => {
  const share = at / STEPS;
  return p.log ? p.low * (p.high / p.low) ** share : p.low + share * (p.high - p.low);
};

// What was typed, as a project file has it: a decimal comma is a point, and a plain number has the unit of its field.
// Three digits after a comma may be thousands; the server asks.
export function written(p, text) {
  const plain = text.trim().replace(/^([-+−]?\d*),(\d{1,2}|\d{4,})(?!\d)/, "$1.$2");
  return /^[-+−]?[\d.,]*(e[-+]?\d+)?$/i.test(plain) ? `${plain} ${p.unit}`.trim() : plain;
}
// A text without the unit of its field.
const ownUnit = (p, text) => (p.unit && text.endsWith(" " + p.unit) ? text.slice(0, -p.unit.length - 1) : text);

let rows = new Map();
export const showGoal = (name, value) => rows.get(name).goal(value); // what meets the limit; null where nothing does
export const hideGoals = () => rows.forEach((one) => one.goal(null));

// Show the numbers; where they are those that are shown, what is typed stays as it is.
export function build({ parameters, parts, sources }, slid, typed) {
  const names = parameters.map((p) => p.name + p.unit + p.added).join() + parts.map((p) => p.name + p.present);
  const sourceOf = (p) => sources[p.name] ?? (p.group === "gear" ? sources.gear : undefined) ?? "";
  const form = byId("sliders");
  if (form.dataset.names === names) {
    for (const p of parameters) rows.get(p.name).show(p, sourceOf(p));
    return;
  }
  form.dataset.names = names;
  const focused = form.contains(document.activeElement) && document.activeElement.id;
  form.replaceChildren();
  rows = new Map();
  const groups = new Map();
  for (const p of parameters) {
    const folded = p.group === "gear" && !p.name.slice(5).includes(".");
    if (!groups.has(p.group)) {
      const name = p.group.replaceAll("_", " ");
      const set = folded
        ? element("details", {}, element("summary", { textContent: `${name}: stiffnesses and torques of the catalogue` }))
        : element("fieldset", {}, element("legend", { textContent: name }));
      groups.set(p.group, set);
      form.append(set);
    }
    rows.set(p.name, row(p, slid, typed));
    groups.get(p.group).append(rows.get(p.name).box);
    rows.get(p.name).show(p, sourceOf(p));
  }
  const add = parts.map((part) => {
    const id = "part-" + part.name.replaceAll(" ", "-");
    return button(id, `${part.present ? "Remove" : "Add"} ${part.name}`, () => ask("part", { ...part, id }));
  });
  if (add.length) form.append(element("fieldset", {}, element("legend", { textContent: "parts" }), element("div", { className: "parts" }, ...add)));
  if (focused) byId(focused)?.focus();
}

// The elements of one number: label with the source of the value, field, unit, slider with its ends and the mark of a goal.
function elementsOf(p) {
  const id = "value-" + p.name, named = p.shown_unit ? `${p.label} [${p.shown_unit}]` : p.label;
  const field = element("input", { type: "text", id, inputMode: "text", spellcheck: false });
  const slider = element("input", { type: "range", min: 0, max: STEPS, step: 1, id: id + "-slider" });
  for (const one of [field, slider]) one.setAttribute("aria-label", named);
  field.dataset.name = p.name;
  const group = p.group.replaceAll("_", " ") + " ";
  const inGroup = p.label.startsWith(group) ? p.label.slice(group.length) : p.label;
  const badge = element("small", { className: "source", id: id + "-source" });
  const label = element("label", { htmlFor: id, title: p.help }, inGroup, " ", badge);
  const unit = element("span", { className: "unit" });
  const help = element("span", { id: id + "-help", hidden: true, textContent: p.help });
  const wrong = element("span", { id: id + "-wrong", className: "wrong" });
  const [low, high] = [element("span", { className: "end" }), element("span", { className: "end" })];
  const goalMark = element("button", { type: "button", className: "goal", hidden: true, textContent: "▲" });
  const range = element("div", { className: "range" }, low, element("div", { className: "track" }, slider, goalMark), high);
  const box = element("div", { className: "value" }, label, field, unit, range, wrong, help);
  field.setAttribute("aria-describedby", `${badge.id} ${help.id} ${wrong.id}`);
  return { named, field, slider, badge, unit, wrong, low, high, goalMark, box };
}

// One number with its slider: `show` takes what the server says of it, `goal` marks the value that meets the limit.
function row(p, slid, typed) {
  const { named, field, slider, badge, unit, wrong, low, high, goalMark, box } = elementsOf(p);
  let now = p.value, source = "";
  const showValue = (value) => {
    now = value;
    badge.textContent = state.values["sources." + p.name] ?? (value !== p.value ? "yours" : source || (p.added ? "yours" : "")); // first numbers of a part are assumed
    box.classList.toggle("changed", value !== p.value || Boolean(p.added));
    if (value === null) return;
    [low.textContent, high.textContent] = ends(p, value).map((end) => signed(short(end, 3)));
    slider.setAttribute("aria-valuetext", `${short(value)} ${p.shown_unit}`);
  };
  const showFault = (sentence) => {
    field.setAttribute("aria-invalid", String(Boolean(sentence)));
    wrong.textContent = sentence;
    if (sentence) box.closest("details")?.setAttribute("open", "");
  };
  const change = (text) => {
    const value = Number(text);
    field.value = text;
    unit.textContent = p.shown_unit;
    delete state.values["sources." + p.name];
    if (value === p.value && !p.added) delete state.values[p.name];
    else state.values[p.name] = `${text} ${p.unit}`.trim();
    showFault("");
    showValue(value);
    slid();
  };
  const changeWithSlider = (text) => {
    slider.value = place(p, Number(text));
    change(text);
  };
  slider.addEventListener("input", () => change(short(valueAt(p, Number(slider.value)))));
  goalMark.addEventListener("click", () => {
    changeWithSlider(goalMark.dataset.value);
    slider.focus(); // the mark goes
  });
  field.addEventListener("input", () => {
    delete state.values["sources." + p.name];
    state.values[p.name] = written(p, field.value);
    typed();
  });
  field.addEventListener("keydown", (event) => {
    const direction = { ArrowUp: 1, ArrowDown: -1 }[event.key];
    if (!direction || now === null) return;
    event.preventDefault();
    const step = (event.shiftKey ? 0.1 : 0.01) * (Math.abs(now) || p.high);
    changeWithSlider(short(now + direction * step, 6));
  });
  const goal = (value) => {
    goalMark.hidden = value === null;
    if (value === null) return;
    goalMark.title = `${short(value)} ${p.shown_unit}: oscillation at the limit`;
    goalMark.setAttribute("aria-label", `Set ${named}: ${goalMark.title}`);
    goalMark.dataset.value = short(value);
    goalMark.style.left = `calc(8px + ${place(p, value) / STEPS} * (100% - 16px))`;
  };
  const show = (found, word) => {
    Object.assign(p, found);
    source = word;
    const text = state.values[p.name] ?? `${short(p.value, 6)} ${p.unit}`.trim(), own = ownUnit(p, text);
    if (written(p, field.value) !== text) field.value = own;
    showFault(p.wrong);
    showValue(p.now);
    if (p.now !== null) slider.value = place(p, p.now);
    unit.textContent = p.now !== null && p.unit && own === text ? `= ${short(p.now)} ${p.shown_unit}` : p.shown_unit;
  };
  return { box, show, goal };
}
