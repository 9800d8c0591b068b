// The views: what each asks of the server, and the pictures of what it answers.
import { call, download } from "/static/api.js";
import { colours, draw, element, parts } from "/static/plots.js";
import { asked, remember, state } from "/static/state.js";

let COLOURS, BLUE, RED, GREEN, PINK, ORANGE;
function recolour() {
  COLOURS = colours();
  [BLUE, RED, GREEN, PINK, ORANGE] = COLOURS;
}
recolour();

// What was computed by a job or read from a log is drawn again in other colours, not computed again.
let paints = [];
export const forget = () => { paints = []; };
async function painting(paint) {
  paints.push(paint);
  await paint();
}
export async function repaint() {
  recolour();
  for (const paint of paints) await paint();
  return paints.length > 0;
}

const round = (value, digits = 4) => (value === null || value === undefined ? "–" : Number(value.toPrecision(digits)).toString());
export let project = null;
export const setProject = (found) => { project = found; };

const signed = (unit) => (unit ?? "").replaceAll("*", "·");
const between = (values, unit) => {
  const shown = values.filter((value) => Number.isFinite(value));
  return `from ${round(Math.min(...shown))} to ${round(Math.max(...shown))} ${unit}`;
};
const band = (low, high, colour) => ({ type: "rect", xref: "x", yref: "paper", x0: low, x1: high, y0: 0, y1: 1, fillcolor: colour, opacity: 0.13, line: { width: 0 }, layer: "below" });

function answer(text, good) {
  const place = document.getElementById("answer");
  if (place.textContent !== text) place.textContent = text;
  place.className = good === null || good === undefined ? "" : good ? "good" : "bad";
}

function curve(r, values, name, unit) {
  const hover = `%{x:.5g} ${r.speed_unit}<br>%{y:.4g} ${unit}<extra>%{fullData.name}</extra>`;
  const nearest = (fold) => r.speed.reduce((best, speed, i) => (Math.abs(speed - fold.speed) < Math.abs(r.speed[best] - fold.speed) ? i : best), 0);
  const corners = new Set(r.folds.map(nearest));
  const [sx, sy] = parts(r.speed, values, r.stable, true, corners);
  const [ux, uy] = parts(r.speed, values, r.stable, false, corners);
  const made = [{ x: sx, y: sy, name: `${name}, stable`, mode: "lines", line: { color: BLUE, width: 2.5 }, hovertemplate: hover }];
  if (r.stable.includes(false)) made.push({ x: ux, y: uy, name: "unstable", mode: "lines", line: { color: RED, width: 2, dash: "dash" }, hovertemplate: hover });
  return made;
}

const level = (r, value, name, colour, dash, unit) => ({
  x: [Math.min(...r.speed), Math.max(...r.speed)], y: [value, value], name, mode: "lines",
  line: { color: colour, width: 1.5, dash }, hovertemplate: `${name}: ${round(value)} ${unit}<extra></extra>`,
});

async function response() {
  const r = await call("/api/response", { body: { state: asked(), whole: false }, kind: "view" });
  const x = { title: `${r.speed_name} [${r.speed_unit}]` };
  const shapes = r.avoid.map(([low, high]) => band(low, high, RED));
  const data = curve(r, r.oscillation_arcsec, r.error_name, "arcsec");
  if (r.folds.length) {
    data.push({ x: r.folds.map((f) => f.speed), y: r.folds.map((f) => f.oscillation_arcsec), name: "fold: the motion jumps", mode: "markers", marker: { color: ORANGE, size: 10, symbol: "diamond" }, hovertemplate: `fold at %{x:.5g} ${r.speed_unit}<extra></extra>` });
  }
  if (r.limit_arcsec !== null) data.push(level(r, r.limit_arcsec, "limit", GREEN, "dot", "arcsec"));
  if (r.avoid.length) data.push({ x: [null], y: [null], name: "speeds to avoid", mode: "markers", marker: { symbol: "square", size: 12, color: RED, opacity: 0.25 } });
  const table = { [`speed [${r.speed_unit}]`]: r.speed, "oscillation [arcsec]": r.oscillation_arcsec, "peak with mean [arcsec]": r.peak_arcsec, "stable": r.stable.map(Number), "largest torque [N*m]": r.torque, "cubic mean torque [N*m]": r.mean_torque };
  await draw("response", { data, layout: { xaxis: x, yaxis: { title: "oscillation [arcsec, 0-to-peak]", rangemode: "tozero" }, shapes }, table, label: `Oscillation of the ${r.error_name} over the ${r.speed_name}: at most ${round(r.largest.oscillation_arcsec)} arcsec at ${round(r.largest.speed)} ${r.speed_unit}` });
  const torque = curve(r, r.torque, "largest torque in the gear", "N·m");
  const dashes = ["dot", "dashdot", "longdash"], tints = [GREEN, ORANGE, PINK];
  r.torque_limits.filter((l) => l.torque < 4 * Math.max(...r.torque)).forEach((l, i) => torque.push(level(r, l.torque, l.name, tints[i % 3], dashes[i % 3], "N·m")));
  await draw("torque", { data: torque, layout: { xaxis: x, yaxis: { title: "torque [N·m]", rangemode: "tozero" } }, table, label: `Largest torque in the gear over the ${r.speed_name}, ${between(r.torque, "N·m")}`, size: "second" });
  const said = `Oscillation up to ${round(r.largest.oscillation_arcsec)} arcsec at ${round(r.largest.speed)} ${r.speed_unit}`;
  const unknown = !r.covered && r.largest.oscillation_arcsec <= r.limit_arcsec;
  const against = r.limit_arcsec !== null && unknown ? `, of the stable motions that are known; at some speeds none is, and there the limit of ${round(r.limit_arcsec)} arcsec is not known to be met.` : r.limit_arcsec === null ? "; the project has no limit." : `, ${r.largest.oscillation_arcsec <= r.limit_arcsec ? "within" : "above"} the limit of ${round(r.limit_arcsec)} arcsec.`;
  const leaves = r.unstable.length ? ` No motion of the curve is stable at ${r.unstable.map(([a, b]) => `${round(a)} to ${round(b)}`).join(", ")} ${r.speed_unit}: the drive leaves it there.` : "";
  const failures = r.failures.map((text) => signed(text) + " ").join("");
  const keep = r.avoid.length ? ` Avoid ${r.avoid.map(([a, b]) => `${round(a)} to ${round(b)}`).join(", ")} ${r.speed_unit}.` : "";
  const [low, mean, high] = r.load_torques;
  const loads = low < high ? ` This is for ${round(mean)} N·m on the load; the report follows it from ${round(low)} to ${round(high)} N·m and gives the verdict.` : "";
  answer(failures + said + against + leaves + keep + loads, r.passes);
  const motor = r.required_motor ? `The motor must give ${low < high ? "at least" : "up to"} ${round(r.required_motor.torque)} N·m, ${round(r.required_motor.holding_torque)} N·m of it at steady speed, and turn at up to ${round(r.required_motor.largest_speed)} ${r.speed_unit}.` : "";
  return [r.message === "reached both ends" ? "" : r.message, motor, ...r.remarks];
}

function speedControl(again) {
  const controls = document.getElementById("controls");
  if (!controls.childElementCount) {
    const { low, high, unit } = project.speed;
    const field = element("input", { type: "number", step: "any", id: "speed", value: state.options.speed ?? round((low + high) / 2) });
    state.options.speed = field.value;
    remember();
    field.addEventListener("input", () => { state.options.speed = field.value; again(); });
    controls.append(element("label", {}, "Speed ", field, " " + unit));
  }
  return Number(document.getElementById("speed").value);
}

async function motion(again) {
  const speed = speedControl(again);
  if (!(speed > 0)) throw new Error("the speed is not a positive number");
  const r = await call("/api/motion", { body: { state: asked(), speed }, kind: "view" });
  const [low, high] = r.load_torques;
  const under = low < high ? `, under ${round(r.load_torque)} N·m on the load` : "";
  answer(`At ${round(speed)} ${project.speed.unit}${under}, the ${r.error_name} oscillates by ${round(r.oscillation_arcsec)} arcsec about its mean; it lies between ${round(Math.min(...r.error_arcsec))} and ${round(Math.max(...r.error_arcsec))} arcsec. The torque in the gear reaches ${round(r.torque)} N·m.`);
  await draw("time", { data: [{ x: r.time.map((t) => 1e3 * t), y: r.error_arcsec, mode: "lines", name: r.error_name, line: { color: BLUE, width: 2 }, hovertemplate: "%{x:.4g} ms<br>%{y:.4g} arcsec<extra></extra>" }], layout: { showlegend: false, xaxis: { title: "time [ms]" }, yaxis: { title: `${r.error_name} [arcsec]` } }, table: { "time [s]": r.time, "error [arcsec]": r.error_arcsec, "rate [arcsec/s]": r.rate_arcsec_per_s }, label: `The ${r.error_name} over time, ${between(r.error_arcsec, "arcsec")}`, size: "second" });
  const [left, right] = [Math.min(...r.error_arcsec), Math.max(...r.error_arcsec)], margin = 0.05 * (right - left) || 1;
  await draw("phase", { data: [
    { x: r.error_arcsec, y: r.rate_arcsec_per_s, mode: "lines", name: "trajectory", line: { color: BLUE, width: 1.5 }, hovertemplate: "%{x:.4g} arcsec<br>%{y:.4g} arcsec/s<extra></extra>" },
    { x: r.poincare.error_arcsec, y: r.poincare.rate_arcsec_per_s, mode: "markers", name: "once a turn of the base angle", marker: { color: RED, size: 9, symbol: "diamond" }, hovertemplate: "%{x:.4g} arcsec<br>%{y:.4g} arcsec/s<extra></extra>" },
  ], layout: { xaxis: { title: `${r.error_name} [arcsec]`, range: [left - margin, right + margin] }, yaxis: { title: "its rate [arcsec/s]" } }, table: { "error [arcsec]": r.error_arcsec, "rate [arcsec/s]": r.rate_arcsec_per_s }, label: `Phase portrait: ${r.error_name} ${between(r.error_arcsec, "arcsec")}, rate ${between(r.rate_arcsec_per_s, "arcsec/s")}` });
  return r.remarks;
}

async function move() {
  const r = await call("/api/move", { body: { state: asked() }, kind: "view" });
  const settled = r.settling_time === null ? "does not settle within the run" : r.settling_time === 0 ? `is within ${round(r.window_arcsec)} arcsec from the end of the move on` : `settles within ${round(r.window_arcsec)} arcsec in ${round(1e3 * r.settling_time)} ms`;
  const failures = r.failures.map((text) => signed(text) + " ").join("");
  answer(`${failures}The move takes ${round(r.duration)} s; the load is off by up to ${round(r.peak_arcsec)} arcsec and ${settled}.`, r.limits.length ? r.passes : null);
  const over = (y, name, unit, colour) => [{ x: r.time, y, mode: "lines", name, line: { color: colour, width: 2 }, hovertemplate: `%{x:.4g} s<br>%{y:.4g} ${unit}<extra></extra>` }];
  const table = { "time [s]": r.time, "reference [deg]": r.reference_deg, "pointing error [arcsec]": r.error_arcsec, "motor torque [N*m]": r.motor_torque, "gear torque [N*m]": r.gear_torque, "motor speed [rpm]": r.motor_speed };
  const x = { title: "time [s]" };
  await draw("move-error", { data: over(r.error_arcsec, "pointing error", "arcsec", BLUE), layout: { showlegend: false, xaxis: x, yaxis: { title: "pointing error [arcsec]" } }, table, label: `Pointing error over the move, ${between(r.error_arcsec, "arcsec")}` });
  await draw("move-torque", { data: over(r.gear_torque, "gear torque", "N·m", RED), layout: { showlegend: false, xaxis: x, yaxis: { title: "gear torque [N·m]" } }, table, label: `Torque in the gear over the move, ${between(r.gear_torque, "N·m")}`, size: "second" });
  await draw("move-speed", { data: over(r.motor_speed, "motor speed", "rpm", GREEN), layout: { showlegend: false, xaxis: x, yaxis: { title: "motor speed [rpm]" } }, table, label: `Speed of the motor over the move, ${between(r.motor_speed, "rpm")}`, size: "second" });
  return r.remarks;
}

// --- jobs ---------------------------------------------------------------------------------------------------------
let running = null;

export async function stop() {
  const id = running;
  running = null;
  if (id) await call("/api/jobs/" + id, { method: "DELETE" }).catch(() => {});
}

export const job = (body, told) => followed(() => call("/api/jobs", { body: { state: asked(), ...body } }), told);

async function followed(begin, told) {
  await stop();
  const { id } = await begin();
  running = id;
  for (;;) {
    await new Promise((resolve) => setTimeout(resolve, 150));
    if (running !== id) return null;
    const now = await call("/api/jobs/" + id);
    told(now);
    if (now.state === "failed") { running = null; throw new Error(now.error); }
    if (now.state === "cancelled") { running = null; return null; }
    if (now.state === "done") { await stop(); return now.result; }
  }
}

function jobControls(label, begin) {
  const controls = document.getElementById("controls");
  if (controls.querySelector("#begin")) return outdated();
  const start = element("button", { type: "button", id: "begin", textContent: label });
  const cancel = element("button", { type: "button", id: "cancel", textContent: "Cancel", disabled: true });
  const bar = element("progress", { max: 1, value: 0, id: "progress" });
  bar.setAttribute("aria-label", "progress");
  const stage = element("span", { id: "stage" });
  stage.setAttribute("aria-live", "polite");
  controls.append(start, cancel, bar, stage);
  const told = (now) => {
    bar.value = now.share;
    const left = now.seconds_left === null ? "" : `, about ${Math.ceil(now.seconds_left)} s left`;
    stage.textContent = now.stage + left;
  };
  start.addEventListener("click", async () => {
    start.disabled = true;
    cancel.disabled = false;
    const status = document.getElementById("status");
    status.className = "";
    status.textContent = "";
    const drive = JSON.stringify(asked());
    try {
      if ((await begin(told)) === null) stage.textContent = "cancelled";
      else if (JSON.stringify(asked()) !== drive) outdated();
      else if (state.view !== "log") {
        state.options.run = state.view;
        await remember();
      }
    } catch (error) {
      stage.textContent = "";
      status.className = "bad";
      status.textContent = error.message;
    }
    start.disabled = false;
    cancel.disabled = true;
  });
  cancel.addEventListener("click", stop);
  if (state.options.run === state.view) start.click(); // the address is that of a computed picture
  return undefined;
}

function outdated() {
  if (!paints.length || state.view === "log") return;
  delete state.options.run;
  document.getElementById("stage").textContent = "something has changed since; compute again";
  remember();
}

const say = (remarks) => document.getElementById("remarks").replaceChildren(element("ul", {}, ...remarks.map((text) => element("li", { textContent: text }))));
const heat = { colorscale: "Cividis", colorbar: { title: { text: "arcsec", side: "right" }, thickness: 14 } };

function mapAxes() {
  return ["across", "along"].map((key) => {
    const p = project.parameters.find((one) => one.name === document.getElementById("map-" + key).value);
    const now = parseFloat(state.values[p.name] ?? p.value), n = Number(document.getElementById("map-count").value);
    return { p, values: Array.from({ length: n }, (_, i) => Number((0.5 * now * 4 ** (i / (n - 1))).toPrecision(5))) };
  });
}

const asTexts = (axes) => axes.map(({ p, values }) => ({ name: p.name, values: values.map((v) => `${v} ${p.unit}`.trim()) }));

async function map() {
  const controls = document.getElementById("controls");
  answer("Largest oscillation over two numbers of the drive, each from half to twice its value.");
  if (controls.childElementCount) {
    outdated();
    return [];
  }
  const able = project.parameters.filter((p) => p.value > 0 && !p.name.startsWith("speed.") && !p.name.startsWith("limit."));
  const pick = (key, usual, at) => {
    const list = element("select", { id: "map-" + key }, ...able.map((p) => element("option", { value: p.name, textContent: p.label })));
    list.value = able.some((p) => p.name === state.options[key]) ? state.options[key] : (able.find((p) => usual.test(p.name)) ?? able[Math.min(at, able.length - 1)]).name;
    list.addEventListener("change", () => { state.options[key] = list.value; remember(); });
    return list;
  };
  const across = pick("across", /kinematic_error.*amplitude$/, 0), along = pick("along", /^damping[.]/, 1);
  const count = element("select", { id: "map-count" }, ...[10, 20, 40].map((n) => element("option", { value: n, textContent: `${n} × ${n}` })));
  count.value = ["10", "20", "40"].includes(state.options.count) ? state.options.count : "10";
  count.addEventListener("change", () => { state.options.count = count.value; remember(); });
  controls.append(element("label", {}, "Across ", across), element("label", {}, "Up ", along), element("label", {}, "Points ", count));
  jobControls("Compute the map", async (told) => {
    const [a, b] = mapAxes();
    const r = await job({ kind: "map", axes: asTexts([a, b]) }, told);
    if (r === null) return null;
    const table = { [`${a.p.label} [${a.p.unit}]`]: b.values.flatMap(() => a.values), [`${b.p.label} [${b.p.unit}]`]: b.values.flatMap((v) => a.values.map(() => v)), "largest oscillation [arcsec]": r.largest_oscillation_arcsec.flat() };
    await painting(() => draw("map", { data: [{ type: "heatmap", x: a.values, y: b.values, z: r.largest_oscillation_arcsec, ...heat, hovertemplate: `%{x:.4g} ${a.p.shown_unit}<br>%{y:.4g} ${b.p.shown_unit}<br>%{z:.4g} arcsec<extra></extra>` }], layout: { showlegend: false, xaxis: { title: `${a.p.label} [${a.p.shown_unit}]`, type: "log" }, yaxis: { title: `${b.p.label} [${b.p.shown_unit}]`, type: "log" } }, table, label: `Largest oscillation over ${a.p.label} and ${b.p.label}, ${between(r.largest_oscillation_arcsec.flat(), "arcsec")}`, size: "square" }));
    answer(`Largest oscillation over ${a.p.label} and ${b.p.label}: ${between(r.largest_oscillation_arcsec.flat(), "arcsec")}.`);
    say(r.remarks);
    return r;
  });
  return [];
}

async function speedMap() {
  answer("Which motor speeds are allowed under which load, and where orders meet resonances.");
  const controls = document.getElementById("controls");
  if (!controls.childElementCount) {
    const search = element("input", { type: "checkbox", id: "search", checked: state.options.search !== "no" });
    search.addEventListener("change", () => { state.options.search = search.checked ? "yes" : "no"; remember(); });
    const loads = element("input", { type: "text", id: "loads", value: state.options.loads ?? "", placeholder: "the project's, or -178; -89; 0", size: 26 });
    loads.addEventListener("input", () => { state.options.loads = loads.value; outdated(); remember(); });
    controls.append(element("label", {}, "Loads [N·m] ", loads), element("label", {}, search, " look for subharmonics and other motions apart from the curves (takes longer)"));
  }
  jobControls("Compute the speed map", async (told) => {
    const asks = mapOptions(), own = asks.loads.length ? "" : " of the project";
    const r = await job({ kind: "speed-map", ...asks }, told);
    if (r === null) return null;
    await painting(() => paintSpeedMap(r));
    const [first, last] = [r.load[0], r.load[r.load.length - 1]].map((load) => round(load)), unit = signed(r.load_unit);
    const loads = r.load.length === 1 ? `the load${own}, ${first} ${unit}` : `all ${r.load.length} loads${own}, ${first} to ${last} ${unit}`;
    const allowed = r.allowed.map(([a, b]) => `${round(a)} to ${round(b)}`).join(", ");
    const failures = r.failures.map((text) => signed(text) + " ").join("");
    answer(`${failures}Allowed under ${loads}: ${allowed ? allowed + " rpm" : "no speed"} (red frames: ${signed(r.rule)}).`, failures ? false : null);
    say(r.remarks);
    return r;
  });
  return [];
}

// What is asked of the speed map. A comma between two digits may be a decimal one or not, and is asked about.
function mapOptions() {
  const text = state.options.loads ?? "", texts = text.split(/[;,\s]+/).filter(Boolean), loads = texts.map(Number);
  const wrong = /\d,\d/.test(text) ? text.trim() : texts.find((_, i) => !Number.isFinite(loads[i]));
  if (wrong !== undefined) throw new Error(`loads: ${wrong} is not clear; write torques in N·m with semicolons between them, such as -89.5; -44; 0`);
  return { search: state.options.search !== "no", loads };
}

async function paintSpeedMap(r) {
  const steps = r.load.slice(1).map((load, i) => (load - r.load[i]) / 2), last = r.load.length - 1;
  const below = (i) => r.load[i] - (steps[Math.max(i - 1, 0)] ?? 0.5), above = (i) => r.load[i] + (steps[Math.min(i, last - 1)] ?? 0.5);
  const shapes = r.forbidden.flatMap((bands, i) => bands.map(([low, high]) => ({ type: "rect", x0: low, x1: high, y0: below(i), y1: above(i), line: { color: RED, width: 2 } })));
  const cells = r.load.flatMap((load) => r.speed.map(() => load));
  await draw("speed-map", { data: [
    { type: "heatmap", x: r.speed, y: [...r.load.map((_, i) => below(i)), above(last)], z: r.oscillation_arcsec, ...heat, customdata: r.load.map((load) => r.speed.map(() => load)), hovertemplate: `%{x:.5g} rpm<br>%{customdata:.4g} ${signed(r.load_unit)}<br>%{z:.4g} arcsec<extra></extra>` },
  ], layout: { showlegend: false, xaxis: { title: "motor speed [rpm]" }, yaxis: { title: `${r.load_name} [${signed(r.load_unit)}]`, tickvals: r.load, ticktext: r.load.map((load) => round(load)) }, shapes }, table: { "load": cells, "motor speed [rpm]": r.load.flatMap(() => r.speed), "oscillation [arcsec]": r.oscillation_arcsec.flat(), "gear torque [N*m]": r.torque.flat() }, label: `Oscillation over speed and load, ${between(r.oscillation_arcsec.flat(), "arcsec")}, with forbidden speeds framed` });
  const lines = r.lines.filter((l) => l.excited);
  const dashes = ["solid", "dash", "dot", "dashdot"], orders = [...new Set(lines.map((l) => l.order))];
  const upright = Math.max(...lines.flatMap((l) => l.amplitude_arcsec)) || Math.max(...r.oscillation_arcsec.flat().filter(Number.isFinite)); // of a speed that no amplitude changes
  const path = (l) => (l.speed.length === 1 ? { x: [l.speed[0], l.speed[0]], y: [0, upright] } : { x: l.speed, y: l.amplitude_arcsec });
  await draw("campbell", { data: lines.map((l, i) => ({ ...path(l), mode: "lines", name: `order ${round(l.order)}`, legendgroup: l.order, showlegend: lines.findIndex((one) => one.order === l.order) === i, line: { color: COLOURS[orders.indexOf(l.order) % COLOURS.length], dash: dashes[orders.indexOf(l.order) % 4] }, hovertemplate: `%{x:.5g} rpm<br>%{y:.4g} arcsec<extra>order ${round(l.order)}, ${round(l.load)} ${signed(r.load_unit)}</extra>` })), layout: { xaxis: { title: "motor speed at the resonance [rpm]", range: [r.speed[0], r.speed[r.speed.length - 1]] }, yaxis: { title: "torsion amplitude [arcsec]" } }, table: { "order": lines.flatMap((l) => l.speed.map(() => l.order)), "load": lines.flatMap((l) => l.speed.map(() => l.load)), "motor speed [rpm]": lines.flatMap((l) => l.speed), "amplitude [arcsec]": lines.flatMap((l) => l.amplitude_arcsec) }, label: `Campbell diagram: speed at which each order meets the resonance, against amplitude, ${between(lines.flatMap((l) => l.speed), "rpm")}` });
}

async function compensation() {
  answer("The pointing error before and after compensation in the motor's loop, at the speed where the largest order meets the resonance.");
  jobControls("Design and run", async (told) => {
    const r = await job({ kind: "compensation" }, told);
    if (r === null) return null;
    const kinds = [["rms_arcsec", "rms"], ["three_sigma_arcsec", "3 sigma"], ["peak_arcsec", "peak with mean"]];
    const bars = (one, name, colour, pattern) => ({ type: "bar", name, x: kinds.map(([, text]) => text), y: kinds.map(([key]) => one[key]), text: kinds.map(([key]) => round(one[key], 3)), textposition: "outside", cliponaxis: false, marker: { color: colour, pattern: { shape: pattern } }, hovertemplate: "%{y:.4g} arcsec<extra>%{fullData.name}</extra>" });
    await painting(() => draw("compensation", { data: [bars(r.before, "before", RED, "/"), bars(r.after, "after", BLUE, "")], layout: { barmode: "group", yaxis: { title: "pointing error [arcsec]" } }, table: { "quantity": kinds.map(([, text]) => text), "before [arcsec]": kinds.map(([key]) => r.before[key]), "after [arcsec]": kinds.map(([key]) => r.after[key]) }, label: `Pointing error before and after compensation: rms ${round(r.before.rms_arcsec)} and ${round(r.after.rms_arcsec)} arcsec` }));
    const gears = r.other_gears.map((g) => `${Math.abs(100 * g.stiffness)} % ${g.stiffness < 0 ? "softer" : "stiffer"}`);
    const rest = (g) => (g.after_rms_arcsec === null ? "growing" : `${round(g.after_rms_arcsec, 3)} arcsec`);
    if (gears.length) {
      const names = [gears[0], "as the model", ...gears.slice(1)], at = (key) => [r.other_gears[0], { before_rms_arcsec: r.before.rms_arcsec, after_rms_arcsec: r.after.rms_arcsec }, ...r.other_gears.slice(1)].map((g) => g[key]);
      const bar = (key, name, colour, pattern) => ({ type: "bar", name, x: names, y: at(key), text: at(key).map((value) => round(value, 3)), textposition: "outside", cliponaxis: false, marker: { color: colour, pattern: { shape: pattern } }, hovertemplate: "%{y:.4g} arcsec<extra>%{fullData.name}</extra>" });
      await painting(() => draw("gears", { data: [bar("before_rms_arcsec", "before", RED, "/"), bar("after_rms_arcsec", "after", BLUE, "")], layout: { barmode: "group", xaxis: { title: "stiffness of the gear" }, yaxis: { title: "rms [arcsec]" } }, table: { "gear": names, "before [arcsec]": at("before_rms_arcsec"), "after [arcsec]": at("after_rms_arcsec") }, label: `Pointing error on other gears: ${gears.map((name, i) => `${name} ${rest(r.other_gears[i])}`).join(", ")}`, size: "second" }));
    }
    const others = gears.length ? ` On a gear ${gears.map((name, i) => `${name}: ${rest(r.other_gears[i])}`).join(", ")}.` : "";
    const not = r.excluded ? ` This does not count: ${r.excluded}.` : r.stable ? "" : " The error grows.";
    answer(`${r.title[0].toUpperCase()}${r.title.slice(1)}, at ${round(r.speed)} rpm: rms ${round(r.before.rms_arcsec, 3)} arcsec before, ${round(r.after.rms_arcsec, 3)} arcsec after.${others} The motor gives up to ${round(r.torque, 3)} N·m.${not}`, not ? false : null);
    document.getElementById("assumed")?.remove();
    document.getElementById("plots").prepend(element("div", { id: "assumed" }, "Assumed:", element("ul", {}, ...r.assumed.map((text) => element("li", { textContent: text })))));
    say(r.remarks);
    return r;
  });
  return [];
}

// --- logs ---------------------------------------------------------------------------------------------------------
export async function readLog(file) {
  if (file.size > 20 * 1024 * 1024) throw new Error("the log is larger than 20 MiB; cut it first");
  const r = await call("/api/log?name=" + encodeURIComponent(file.name), { raw: file, kind: "view" });
  answer(`${file.name}: ${r.samples} samples, ${round(r.from_s)} to ${round(r.to_s)} s, ${round(r.rate_Hz)} Hz, ${r.channels.length} channels${r.ratio === null ? "" : `, ratio ${round(r.ratio)}`}.`);
  for (const [i, c] of r.channels.slice(0, 6).entries()) {
    await painting(() => draw("log-" + c.name, { data: [{ x: r.time, y: c.values, mode: "lines", name: c.name, line: { color: COLOURS[i % COLOURS.length] }, hovertemplate: `%{x:.6g} s<br>%{y:.5g} ${signed(c.unit)}<extra></extra>` }], layout: { showlegend: false, xaxis: { title: "time [s]" }, yaxis: { title: `${c.name.replaceAll("_", " ")} [${signed(c.unit)}]` } }, table: { "time [s]": r.time, [`${c.name} [${c.unit}]`]: c.values }, label: `${c.name.replaceAll("_", " ")} over time, ${between(c.values, c.unit)}`, size: "second" }));
  }
  dropped = file;
  const names = r.channels.map((c) => c.name);
  if (names.includes("motor_angle") && names.includes("load_angle")) jobControls("Identify the drive", identifyDrive);
  else {
    for (const id of ["begin", "cancel", "progress", "stage"]) document.getElementById(id)?.remove();
    r.notes.unshift("Stiffness, damping and kinematic error need both angles, motor_angle and load_angle; this log has not both: its orders are shown.");
  }
  const rows = r.orders.lines.map((l) => element("tr", {}, ...[round(l.order), `${round(l.amplitude)} ± ${round(l.error, 2)} ${signed(r.orders.unit)}`, l.kind].map((text) => element("td", { textContent: text }))));
  const head = element("tr", {}, ...["order", `amplitude of ${(r.orders.of ?? "").replaceAll("_", " ")}`, "kind"].map((text) => element("th", { textContent: text })));
  const table = rows.length ? element("table", { id: "orders" }, head, ...rows) : element("p", { textContent: document.getElementById("begin") ? "" : r.orders.why });
  document.getElementById("plots").prepend(element("div", { className: "wide" }, table));
  return r.notes;
}

let dropped = null;

async function identifyDrive(told) {
  const body = new Blob([JSON.stringify({ state: asked() }), "\n", dropped]);
  const r = await followed(() => call("/api/identify?name=" + encodeURIComponent(dropped.name), { raw: body }), told);
  if (r === null) return null;
  const cells = (n) => [n.name, `${round(n.value, 5)} ${n.unit}`, `${round(n.low, 5)} to ${round(n.high, 5)}`];
  const row = (kind, texts) => element("tr", {}, ...texts.map((text) => element(kind, { textContent: text })));
  const table = element("table", { id: "identified" }, row("th", ["number", "found", "95 % interval"]), ...r.numbers.map((n) => row("td", cells(n))));
  const use = element("button", { type: "button", id: "use", textContent: "Take these numbers into the drive" });
  if (r.usable) use.addEventListener("click", () => document.dispatchEvent(new CustomEvent("project", { detail: r.project })));
  else use.disabled = true;
  document.getElementById("identified-drive")?.remove();
  document.getElementById("plots").prepend(element("div", { className: "wide", id: "identified-drive" }, table, use));
  const over = (y, name, colour, dash) => ({ x: r.time, y, mode: "lines", name, line: { color: colour, width: 1.5, dash }, hovertemplate: "%{x:.4g} s<br>%{y:.4g} arcsec<extra>%{fullData.name}</extra>" });
  const columns = { "time [s]": r.time, "measured torsion [arcsec]": r.measured_arcsec, "computed torsion [arcsec]": r.computed_arcsec, "residual [arcsec]": r.residual_arcsec };
  await painting(() => draw("identified-torsion", { data: [over(r.measured_arcsec, "measured", BLUE, "solid"), over(r.computed_arcsec, "computed", RED, "dash")], layout: { xaxis: { title: "time [s]" }, yaxis: { title: "torsion [arcsec]" } }, table: columns, label: `Measured and computed torsion over time, measured ${between(r.measured_arcsec, "arcsec")}` }));
  await painting(() => draw("identified-residual", { data: [over(r.residual_arcsec, "residual", ORANGE, "solid")], layout: { showlegend: false, xaxis: { title: "time [s]" }, yaxis: { title: "residual [arcsec]" } }, table: columns, label: `Residual of the torsion over time, ${between(r.residual_arcsec, "arcsec")}`, size: "second" }));
  answer(`${r.headline} ${round(r.rms_arcsec, 3)} arcsec rms are left of the measured torsion.`, r.usable ? null : false);
  say(r.remarks);
  return r;
}

async function log() {
  const controls = document.getElementById("controls");
  answer("Drop a log onto the page: channels, stretches, and orders where the log has them.");
  if (controls.childElementCount) return [];
  const input = element("input", { type: "file", id: "log-file", accept: ".csv,.txt,.dat,.npz,.mat,.parquet,.mf4" });
  input.addEventListener("change", () => input.files[0] && document.dispatchEvent(new CustomEvent("log", { detail: input.files[0] })));
  controls.append(element("label", { className: "drop" }, "Drop a CSV, npz, mat, parquet or mf4 file here, or choose one: ", input));
  return [];
}

export const VIEWS = {
  response: { name: "Response", show: response }, motion: { name: "Motion at a speed", show: motion },
  move: { name: "Move", show: move }, "speed-map": { name: "Speed map", show: speedMap },
  compensation: { name: "Compensation", show: compensation }, map: { name: "Two-parameter map", show: map }, log: { name: "Log", show: log },
};

function scriptView() {
  if (state.view === "log") throw new Error("a log has no script of the page; strainwave identify-drive PROJECT LOG does the same");
  const view = { view: state.view };
  if (state.view === "motion") view.speed = Number(document.getElementById("speed").value);
  if (state.view === "speed-map") Object.assign(view, mapOptions());
  if (state.view === "map") view.axes = asTexts(mapAxes());
  return view;
}

export async function take(what) {
  const stem = (project?.title ?? "drive").replace(/[^\w.-]+/g, "-").slice(0, 60);
  if (what === "project") return download(stem + ".yaml", await call("/api/export/project", { body: { state: asked() } }), "application/yaml");
  if (what === "script") return download(stem + ".py", await call("/api/export/script", { body: { state: asked(), ...scriptView() } }), "text/x-python");
  const status = document.getElementById("status");
  const page = await job({ kind: "report" }, (now) => { status.textContent = `report: ${now.stage}`; });
  status.textContent = "";
  return page && download(stem + ".html", page, "text/html");
}
