// Sliders and number fields, made from the description that the server gives of a project's numbers.
import { element } from "/static/plots.js";
import { state } from "/static/state.js";

const STEPS = 1000;
const numberOf = (text) => parseFloat(text);
const short = (value) => Number(value.toPrecision(4)).toString();
const ends = (p, value) => (p.log ? [p.low, p.high] : [Math.min(p.low, value), Math.max(p.high, value)]);

const place = (p, value) => {
  const [low, high] = ends(p, value);
  const share = p.log ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
  return Math.round(STEPS * Math.min(1, Math.max(0, share)));
};
const valueAt = (p, at) => {
  const share = at / STEPS;
  return p.log ? p.low * (p.high / p.low) ** share : p.low + share * (p.high - p.low);
};

export function build({ parameters, parts }, changed) {
  const form = document.getElementById("sliders");
  form.replaceChildren();
  const groups = new Map();
  for (const p of parameters) {
    if (!groups.has(p.group)) {
      const set = element("fieldset", {}, element("legend", { textContent: p.group.replaceAll("_", " ") }));
      groups.set(p.group, set);
      form.append(set);
    }
    groups.get(p.group).append(row(p, changed));
  }
  const add = parts.map((part) => {
    const id = "part-" + part.name.replaceAll(" ", "-");
    const button = element("button", { type: "button", id, textContent: `${part.present ? "Remove" : "Add"} ${part.name}` });
    button.addEventListener("click", () => document.dispatchEvent(new CustomEvent("part", { detail: { ...part, id } })));
    return button;
  });
  if (add.length) form.append(element("fieldset", {}, element("legend", { textContent: "parts" }), element("div", { className: "parts" }, ...add)));
}

function row(p, changed) {
  const id = "value-" + p.name;
  const given = state.values[p.name];
  const value = given === undefined ? p.value : numberOf(given);
  const field = element("input", { type: "number", id, step: "any", value: short(value) });
  field.dataset.name = p.name;
  const named = p.shown_unit ? `${p.label} [${p.shown_unit}]` : p.label;
  field.setAttribute("aria-label", named);
  const slider = element("input", { type: "range", min: 0, max: STEPS, step: 1, value: place(p, value), id: id + "-slider" });
  slider.setAttribute("aria-label", named);
  const group = p.group.replaceAll("_", " ") + " ";
  const inGroup = p.label.startsWith(group) ? p.label.slice(group.length) : p.label;
  const label = element("label", { htmlFor: id, textContent: inGroup, title: p.help });
  const box = element("div", { className: "value" }, label, field, element("span", { className: "unit", textContent: p.shown_unit }), slider);
  const tell = (now) => slider.setAttribute("aria-valuetext", `${short(now)} ${p.shown_unit}`);
  tell(value);
  box.classList.toggle("changed", given !== undefined);
  if (p.help) {
    const help = element("span", { id: id + "-help", hidden: true, textContent: p.help });
    box.append(help);
    field.setAttribute("aria-describedby", help.id);
  }
  const take = (now) => {
    const wrong = !Number.isFinite(now);
    field.setAttribute("aria-invalid", String(wrong));
    if (wrong) return;
    if (now === p.value && !p.added) delete state.values[p.name];
    else state.values[p.name] = `${now} ${p.unit}`.trim();
    box.classList.toggle("changed", now !== p.value);
    tell(now);
    changed();
  };
  slider.addEventListener("input", () => {
    field.value = short(valueAt(p, Number(slider.value)));
    take(numberOf(field.value));
  });
  field.addEventListener("input", () => {
    const now = numberOf(field.value);
    if (Number.isFinite(now)) slider.value = place(p, now);
    take(now);
  });
  return box;
}
