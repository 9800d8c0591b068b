// Pictures with plotly.js: colours of Okabe and Ito, which colour-blind people tell apart, and line styles with them.
import { download } from "/static/api.js";
import { about, stem } from "/static/state.js";

export const dark = matchMedia("(prefers-color-scheme: dark)");
const ON_LIGHT = ["#0072b2", "#d55e00", "#00815e", "#b0508a", "#b87800", "#2f8fc4", "#707070"];
const ON_DARK = ["#56b4e9", "#ff8a3d", "#2fd0a0", "#e79cc8", "#f0c04a", "#9ad3f5", "#b5b5b5"];
export let COLOURS, BLUE, RED, GREEN, PINK, ORANGE;
export let epoch = 0; // pictures of an earlier one are gone, or in other colours
export function recolour() {
  epoch += 1;
  COLOURS = dark.matches ? ON_DARK : ON_LIGHT;
  [BLUE, RED, GREEN, PINK, ORANGE] = COLOURS;
}
recolour();
const emOf = () => parseFloat(getComputedStyle(document.documentElement).fontSize);

export const byId = (id) => document.getElementById(id);

export function element(tag, fields = {}, ...children) {
  const made = Object.assign(document.createElement(tag), fields);
  made.append(...children);
  return made;
}

export function button(id, text, act, fields = {}) {
  const made = element("button", { type: "button", id, textContent: text, ...fields });
  made.addEventListener("click", act);
  return made;
}

// Ask the page for something: a project, a log, values, a part.
export const ask = (name, detail) => document.dispatchEvent(new CustomEvent(name, { detail }));

// Put an element among the pictures, in place of the one with its id.
export function placed(way, made) {
  byId(made.id)?.remove();
  byId("plots")[way](made);
}

// The text of a result with all its numbers, folded away below the pictures.
export const numbers = (text) => placed("append", element("details", { id: "numbers", className: "wide" }, element("summary", { textContent: "All numbers" }), element("pre", { textContent: text })));

export const round = (value, digits = 4) => (value === null || value === undefined ? "–" : Number(value.toPrecision(digits)).toString());
// A computed number: three digits where it rests on assumed ones.
export const sure = (value) => (Math.abs(value) >= 10 ** about.digits ? String(Math.round(value)) : round(value, about.digits));
export const signed = (text) => (text ?? "").replaceAll("`", "").replaceAll("*", "·").replace(/(?<!\w)-(?=\d)/g, "−"); // units and numbers as they are printed
export const sentences = (texts) => texts.map((text) => signed(text) + " ").join("");
export const between = (values, unit) => {
  const shown = values.filter((value) => Number.isFinite(value));
  return shown.length ? signed(`from ${sure(Math.min(...shown))} to ${sure(Math.max(...shown))} ${unit}`) : "no value";
};

// The sentence that answers the question of a view. It says ✗ of what fails and of what was refused, whose picture is
// that of the drive before: it is dimmed.
export function answer(text, good, stale = false) {
  const line = byId("answer");
  if (line.textContent !== text) line.textContent = text;
  line.className = good === null || good === undefined ? "" : good ? "good" : "bad";
  byId("plots").classList.toggle("stale", stale);
}

export const tabled = (head, rows, fields = {}) => element("table", fields, ...[head, ...rows].map((row, i) => element("tr", {}, ...row.map((one) => element(i ? "td" : "th", {}, one)))));

// A long title has its unit on a line of its own, so that it fits a phone.
const lines = (title) => (title.length > 32 ? title.replace(" [", "<br>[").replace(": ", ":<br>") : title);

function layoutOf(layout) {
  const styles = getComputedStyle(document.documentElement);
  const [ink, line, paper] = ["--ink", "--line", "--paper"].map((name) => styles.getPropertyValue(name).trim());
  const size = parseFloat(styles.fontSize) * 0.87;
  const axis = { gridcolor: line, zerolinecolor: line, linecolor: line, automargin: true, title: { standoff: 8 } };
  const whole = {
    paper_bgcolor: paper, plot_bgcolor: paper, font: { color: ink, size, family: "system-ui, sans-serif" },
    margin: { l: 3 * size, r: 12, t: 2 * size, b: 3 * size }, hovermode: "closest", showlegend: true, uirevision: layout.uirevision ?? "same",
    legend: { orientation: "h", x: 0, y: 1.02, yanchor: "bottom", font: { size } },
    hoverlabel: { bgcolor: paper, bordercolor: line, font: { color: ink } },
    ...layout,
  };
  for (const name of Object.keys(whole).filter((key) => /^[xy]axis/.test(key)).concat(["xaxis", "yaxis"])) {
    const given = whole[name] ?? {};
    const title = typeof given.title === "string" ? { text: lines(given.title) } : given.title;
    whole[name] = { ...axis, ...given, title: { ...axis.title, ...title } };
  }
  return whole;
}

function csvOf(table) {
  const names = Object.keys(table);
  const columns = names.map((name) => table[name]);
  const rows = [names.map((name) => `"${name.replaceAll('"', '""')}"`).join(",")];
  const most = Math.max(...columns.map((column) => column.length));
  for (let i = 0; i < most; i += 1) rows.push(columns.map((column) => column[i] ?? "").join(","));
  return rows.join("\r\n") + "\r\n";
}

// Draw a picture; table holds the data that its CSV gives, by column names with units.
export async function draw(name, { data, layout, table, label, size = "" }) {
  const plots = byId("plots");
  let box = byId("plot-" + name);
  if (!box) {
    box = element("div", { id: "plot-" + name, className: "plot " + size });
    box.setAttribute("role", "img");
    const take = element("div", { className: "take" }, name.replaceAll("-", " ") + " ");
    for (const format of ["SVG", "PNG", "CSV"]) {
      const one = button(`take-${name}-${format}`, format, () => save(box, name, format.toLowerCase()));
      one.setAttribute("aria-label", `Save ${name} as ${format}`);
      take.append(one);
    }
    document.querySelector("#save > div").append(take);
    plots.append(element("figure", {}, box));
    for (const former of plots.querySelectorAll(".plot[data-drawn]")) window.Plotly.Plots.resize(former); // beside which it stands now
  }
  box.setAttribute("aria-label", label);
  box.table = table;
  const config = { displaylogo: false, responsive: true, displayModeBar: false, doubleClick: "reset" };
  const scale = emOf() / 15;
  for (const trace of data) {
    if (trace.line) trace.line.width = (trace.line.width ?? 2) * scale;
    if (trace.marker?.size) trace.marker.size *= scale;
  }
  await window.Plotly.react(box, data, layoutOf(layout), config);
  box.drawn = (box.drawn ?? 0) + 1;
  box.dataset.drawn = box.drawn;
}

// What draws the pictures of a view until another view or other colours begin, which end it.
export function pictures() {
  const mine = epoch;
  return async (...picture) => {
    await draw(...picture);
    if (epoch !== mine) throw new DOMException("the view has changed", "AbortError");
  };
}

// A picture in the colours of a light page, under the title of the drive.
function onLight(box) {
  const here = getComputedStyle(document.documentElement), root = [...document.styleSheets[0].cssRules].find((rule) => rule.selectorText === ":root").style;
  const pairs = ["--ink", "--line", "--paper"].map((name) => [here.getPropertyValue(name).trim(), root.getPropertyValue(name).trim()]);
  const text = JSON.stringify({ data: box.data, layout: box.layout });
  const { data, layout } = JSON.parse([...pairs, ...COLOURS.map((colour, i) => [colour, ON_LIGHT[i]])].reduce((all, [from, to]) => all.replaceAll(from, to), text));
  const size = layout.font.size;
  return { data, layout: { ...layout, title: { text: about.title, x: 0.5, y: 0.98, yanchor: "top" }, margin: { ...layout.margin, t: 5 * size } } };
}

async function save(box, name, format) {
  const file = `${stem()}-${name}.${format}`;
  if (format === "csv") return download(file, csvOf(box.table), "text/csv");
  const url = await window.Plotly.toImage(onLight(box), { format, width: 1200, height: 700, scale: format === "png" ? 2 : 1 });
  if (format === "svg") return download(file, decodeURIComponent(url.slice(url.indexOf(",") + 1)), "image/svg+xml");
  const bytes = Uint8Array.from(atob(url.slice(url.indexOf(",") + 1)), (c) => c.charCodeAt(0));
  return download(file, new Blob([bytes], { type: "image/png" }));
}

// Pictures over the same speeds or times: their zoom and their crosshair are one.
export function link(names) {
  const boxes = names.map((name) => byId("plot-" + name)), { Plotly } = window;
  for (const box of boxes.filter((one) => !one.linked)) {
    box.linked = true;
    const others = boxes.filter((one) => one !== box);
    box.on("plotly_relayout", (event) => {
      const range = [event["xaxis.range[0]"], event["xaxis.range[1]"]];
      if (range[0] !== undefined) for (const other of others) Plotly.relayout(other, { "xaxis.range": range });
      else if (event["xaxis.autorange"]) for (const other of others.filter((one) => !one.layout.xaxis.autorange)) Plotly.relayout(other, { "xaxis.autorange": true });
    });
    box.on("plotly_hover", (event) => others.forEach((other) => Plotly.Fx.hover(other, { xval: event.xvals[0] }, "xy")));
    box.on("plotly_unhover", () => others.forEach((other) => Plotly.Fx.unhover(other)));
  }
}
export const crosshair = { showspikes: true, spikemode: "across", spikesnap: "data", spikethickness: 1, spikedash: "dot" };

// Stretches of a curve with the same flag. A corner, where the flag changes, belongs to the stretches on both sides.
export function parts(x, y, flags, wanted, corners) {
  const outX = [], outY = [];
  let last = -1;
  for (let i = 1; i < x.length; i += 1) {
    if ((corners.has(i) ? flags[i - 1] : flags[i]) !== wanted) continue;
    for (const at of last === i - 1 ? [i] : [null, i - 1, i]) {
      outX.push(at === null ? null : x[at]);
      outY.push(at === null ? null : y[at]);
    }
    last = i;
  }
  return [outX, outY];
}

// A legend above a picture whose size changed keeps its old place until it is laid out again.
export function legends() {
  for (const box of document.querySelectorAll(".plot[data-drawn]")) window.Plotly.relayout(box, { "legend.y": 1.02 });
}

export function clear() {
  epoch += 1;
  byId("plots").className = "";
  for (const box of document.querySelectorAll(".plot")) window.Plotly.purge(box);
  for (const take of document.querySelectorAll(".take")) take.remove();
  byId("plots").replaceChildren();
}
