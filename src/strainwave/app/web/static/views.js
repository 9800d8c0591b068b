// The views: what each asks of the server, and the pictures of what it answers.
import { call, download } from "/static/api.js";
import { session } from "/static/history.js";
import { run } from "/static/jobs.js";
import { log } from "/static/log.js";
import { compensation, mapOptions, speedMap, tuning } from "/static/maps.js";
import { answer, ask, between, BLUE, button, byId, COLOURS, crosshair, draw, element, epoch, GREEN, link, numbers, ORANGE, parts, pictures, PINK, RED, round, sentences, signed, sure, tabled } from "/static/plots.js";
import { about, asked, remember, state, stem } from "/static/state.js";

const band = (low, high, colour) => ({ type: "rect", xref: "x", yref: "paper", x0: low, x1: high, y0: 0, y1: 1, fillcolor: colour, opacity: 0.13, line: { width: 0 }, layer: "below" });

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

// Curves beside the present one: that before the last change, and those that are pinned.
let current = null, rested = null, ghost = null, pins = [];
document.addEventListener("pause", () => { rested = JSON.stringify(asked()); }); // its answer may still be on the way
const others = () => [...pins, ...(ghost && ghost.drive !== current.drive ? [ghost] : [])].filter((one) => one.r.speed_unit === current.r.speed_unit);
const beside = (key, unit) => others().map(({ name, r }) => ({ x: r.speed, y: r[key], name, mode: "lines", opacity: 0.7, line: { color: COLOURS[6], width: 1.5, dash: name === "before" ? "dot" : ["solid", "dash", "dashdot", "longdash"][pins.findIndex((one) => one.name === name) % 4] }, hovertemplate: `%{y:.4g} ${unit}<extra>%{fullData.name}</extra>` }));

function pinControls(again) {
  const controls = byId("controls");
  const rows = pins.length ? [current, ...pins].map(({ name, r, values }, i) => [i ? name : "now", values, round(r.largest.oscillation_arcsec), round(r.largest.speed), round(r.largest.torque), round(r.required_motor?.torque)]) : [];
  const head = ["curve", "changed values", "largest [arcsec]", `at [${current.r.speed_unit}]`, "largest gear torque [N·m]", "largest motor torque [N·m]"];
  byId("pins")?.remove();
  if (rows.length) byId("plots").append(element("div", { id: "pins", className: "wide" }, tabled(head, rows)));
  if (controls.childElementCount) return;
  controls.append(
    button("pin", "Pin this curve", () => { pins.push({ ...current, name: `${pins.length + 1}: ${about.title}` }); again(); }),
    button("unpin", "Remove pins", () => { pins = []; ghost = null; again(); }),
    button("whole", "Whole range of speeds", () => window.Plotly.relayout("plot-response", { "xaxis.autorange": true, "yaxis.autorange": true })),
  );
}

// A small picture beside the answer, for where the large one is out of sight.
function small(r) {
  const most = Math.max(...r.oscillation_arcsec, r.limit_arcsec ?? 0) || 1, [low, high] = [Math.min(...r.speed), Math.max(...r.speed)];
  const at = (x, y) => `${((300 * (x - low)) / (high - low || 1)).toFixed(1)},${(58 - (56 * y) / most).toFixed(1)}`;
  byId("small-curve").setAttribute("points", r.speed.map((x, i) => at(x, r.oscillation_arcsec[i] ?? most)).join(" "));
  byId("small-limit").setAttribute("points", r.limit_arcsec === null ? "" : [low, high].map((x) => at(x, r.limit_arcsec)).join(" "));
}

// After a pause: the range for assumed numbers, and the held motor, thin. Another drive or view ends it.
let pause = 0;
async function afterwards(picture, top, drive, mine, tell, varies) {
  const gone = () => epoch !== mine || drive !== JSON.stringify(asked());
  const later = (path) => call(path, { body: { state: asked() }, kind: "beside" }).catch((error) => ({ why: error.message }));
  if (gone()) return;
  const s = await later("/api/sureness");
  if (gone()) return;
  if (!s.why) await drawRange(picture, top, s);
  if (gone()) return;
  const sure = s.why ? `The range for assumed numbers cannot be computed: ${signed(s.why)}.` : s.together && `How sure: ${s.together}.`;
  tell(sure, s.met);
  const list = document.querySelector("#remarks ul") ?? byId("remarks").appendChild(element("ul"));
  list.append(...(s.how_sure ?? []).map((textContent) => element("li", { textContent })));
  const of = varies && (await later("/api/loads"));
  if (of && !gone()) tell(sure, s.met, of);
}

async function drawRange(picture, top, s) {
  const line = { mode: "lines", hoverinfo: "skip" }, known = s.how_sure.length > 0;
  const band = known ? [
    { ...line, x: s.speed, y: s.low_arcsec, line: { width: 0 }, showlegend: false },
    { ...line, x: s.speed, y: s.high_arcsec, line: { width: 0 }, fill: "tonexty", fillcolor: BLUE + "33", name: `range for assumed numbers${(s.load ?? "").replace(" ", "<br>")}` },
  ] : [];
  const held = s.held ? [{ ...line, x: s.held.speed, y: s.held.oscillation_arcsec, line: { color: COLOURS[6], width: 1, dash: "dashdot" }, name: "motor held" }] : [];
  picture.data.unshift(...band, ...held);
  picture.layout.yaxis = { ...picture.layout.yaxis, autorange: false, range: [0, Math.max(top, ...(known ? s.high_arcsec.filter(Number.isFinite) : [])) * 1.08] };
  await draw("response", picture);
}

async function drawTorque(draw, r, x, under, table) {
  const torque = [...beside("torque", "N·m"), ...curve(r, r.torque, `largest${under}`, "N·m")];
  const dashes = ["dot", "dashdot", "longdash"], tints = [GREEN, ORANGE, PINK];
  r.torque_limits.filter((l) => l.torque < 4 * Math.max(...r.torque)).forEach((l, i) => torque.push(level(r, l.torque, l.name, tints[i % 3], dashes[i % 3], "N·m")));
  await draw("torque", { data: torque, layout: { hovermode: "x", xaxis: x, yaxis: { title: "torque in the gear [N·m]", rangemode: "tozero" } }, table, label: `Largest torque in the gear${under} over the ${r.speed_name}, ${between(r.torque, "N·m")}`, size: "second" });
  link(["response", "torque"]);
}

async function response(again, answered = () => false) {
  const draw = pictures(), mine = epoch, drive = JSON.stringify(asked());
  clearTimeout(pause);
  const r = await call("/api/response", { body: { state: asked(), whole: false }, kind: "view" });
  const overtaken = answered(); // by a newer value, whose answer is on its way while this one is drawn
  if (current?.drive === rested) ghost = { ...current, name: "before" };
  const unbounded = /grows without bound/.test(r.message); // then the picture has what is near the limit
  if (unbounded) {
    const most = 5 * Math.max(r.limit_arcsec ?? 0, r.oscillation_arcsec[0]), far = r.oscillation_arcsec.map((value) => value > most);
    for (const key of ["oscillation_arcsec", "peak_arcsec", "torque", "mean_torque"]) r[key] = r[key].map((value, i) => (far[i] ? null : value));
  }
  current = { r, drive, values: Object.entries(state.values).map((pair) => pair.join(" ")).join(", ") };
  small(r);
  const x = { title: `${r.speed_name} [${r.speed_unit}]`, ...crosshair };
  const shapes = r.avoid.map(([low, high]) => band(low, high, RED));
  const data = [...beside("oscillation_arcsec", "arcsec"), ...curve(r, r.oscillation_arcsec, r.error_name, "arcsec")];
  if (r.smallest_arcsec) data.push({ x: r.speed, y: r.smallest_arcsec, name: "motor turn with the smallest error", mode: "lines", line: { color: BLUE, width: 1 }, hovertemplate: "%{y:.4g} arcsec<extra>%{fullData.name}</extra>" });
  if (r.folds.length) {
    data.push({ x: r.folds.map((f) => f.speed), y: r.folds.map((f) => f.oscillation_arcsec), name: "fold: the motion jumps", mode: "markers", marker: { color: ORANGE, size: 10, symbol: "diamond" }, hovertemplate: `fold at %{x:.5g} ${r.speed_unit}<extra></extra>` });
  }
  if (r.limit_arcsec !== null) data.push(level(r, r.limit_arcsec, "limit", GREEN, "dot", "arcsec"));
  if (r.avoid.length) data.push({ x: [null], y: [null], name: "speeds to avoid", mode: "markers", marker: { symbol: "square", size: 12, color: RED, opacity: 0.25 } });
  const table = { [`speed [${r.speed_unit}]`]: r.speed, "oscillation [arcsec]": r.oscillation_arcsec, "peak incl. mean [arcsec]": r.peak_arcsec, "stable": r.stable.map(Number), "largest torque [N*m]": r.torque, "cubic mean torque [N*m]": r.mean_torque };
  const picture = { data, layout: { hovermode: "x", xaxis: x, yaxis: { title: "oscillation [arcsec, 0-to-peak]", rangemode: "tozero" }, shapes }, table, label: unbounded ? r.message : signed(r.said) };
  const later = structuredClone(picture), top = Math.max(...data.filter((one) => one.y).flatMap((one) => one.y.filter(Number.isFinite)));
  await draw("response", picture);
  const [low, mean, high] = r.load_torques, under = low < high ? (mean ? ` at ${signed(round(mean))} N·m on the load` : " without the load's torque") : "";
  if (current.drive !== drive) throw new DOMException("a newer one is drawn", "AbortError");
  if (!overtaken) await drawTorque(draw, r, x, under, table);
  pinControls(again);
  const failures = sentences(r.failures);
  const loads = (of) => (low < high ? ` ${of ? signed(of.said ?? `No result for all loads: ${of.why}.`) : "The speeds allowed under every load are being computed."}` : "");
  // A drive that is within its limit with assumed numbers passes where their whole range is within it.
  const tell = (sure, met, of) => {
    const passes = r.passes ?? of?.passes, more = sentences((of?.failures ?? []).filter((text) => !r.failures.includes(text)));
    if (unbounded) return answer(`${r.message[0].toUpperCase()}${r.message.slice(1)}.`, false);
    return answer(`${failures}${more}${signed(r.said)}${loads(of)} ${sure}`.trim(), passes && !met ? null : passes);
  };
  tell(...(r.assumed ? ["The effect of the assumed values is being computed.", null] : ["", true]));
  clearTimeout(pause);
  pause = setTimeout(afterwards, 500, later, top, drive, mine, tell, low < high);
  return [...(unbounded ? [] : [r.message === "reached both ends" ? "" : r.message, r.torque_said]), ...r.remarks];
}

function speedControl(again) {
  const controls = byId("controls");
  if (!controls.childElementCount) {
    const { low, high, unit } = about.speed;
    const field = element("input", { type: "number", step: "any", id: "speed", value: state.options.speed ?? round((low + high) / 2) });
    state.options.speed = field.value;
    remember();
    field.addEventListener("input", () => { state.options.speed = field.value; again(); });
    controls.append(element("label", {}, "Speed ", field, " " + unit));
  }
  return Number(byId("speed").value);
}

async function motion(again) {
  const draw = pictures();
  const speed = speedControl(again);
  if (!(speed > 0)) throw new Error("the speed is not a positive number");
  const r = await call("/api/motion", { body: { state: asked(), speed }, kind: "view" });
  answer(signed(r.said));
  await draw("time", { data: [{ x: r.time.map((t) => 1e3 * t), y: r.error_arcsec, mode: "lines", name: r.error_name, line: { color: BLUE, width: 2 }, hovertemplate: "%{x:.4g} ms<br>%{y:.4g} arcsec<extra></extra>" }], layout: { showlegend: false, xaxis: { title: "time [ms]" }, yaxis: { title: `${r.error_name} [arcsec]` } }, table: { "time [s]": r.time, "error [arcsec]": r.error_arcsec, "rate [arcsec/s]": r.rate_arcsec_per_s }, label: `The ${r.error_name} over time, ${between(r.error_arcsec, "arcsec")}`, size: "second" });
  const [left, right] = [Math.min(...r.error_arcsec), Math.max(...r.error_arcsec)], margin = 0.05 * (right - left) || 1;
  await draw("phase", { data: [
    { x: r.error_arcsec, y: r.rate_arcsec_per_s, mode: "lines", name: "trajectory", line: { color: BLUE, width: 1.5 }, hovertemplate: "%{x:.4g} arcsec<br>%{y:.4g} arcsec/s<extra></extra>" },
    { x: r.poincare.error_arcsec, y: r.poincare.rate_arcsec_per_s, mode: "markers", name: "one point per turn", marker: { color: RED, size: 9, symbol: "diamond" }, hovertemplate: "%{x:.4g} arcsec<br>%{y:.4g} arcsec/s<extra></extra>" },
  ], layout: { xaxis: { title: `${r.error_name} [arcsec]`, range: [left - margin, right + margin] }, yaxis: { title: "rate of the error [arcsec/s]" } }, table: { "error [arcsec]": r.error_arcsec, "rate [arcsec/s]": r.rate_arcsec_per_s }, label: `Phase portrait: ${r.error_name} ${between(r.error_arcsec, "arcsec")}, rate ${between(r.rate_arcsec_per_s, "arcsec/s")}` });
  return r.remarks;
}

function moveControls() {
  const controls = byId("controls"), name = "move.profile.0.type", kind = state.values[name];
  const part = about.parts.find((one) => one.name === "move");
  const shown = byId("move-type");
  if (shown && kind) {
    shown.value = kind;
    return;
  }
  controls.replaceChildren();
  if (part && !part.present) {
    controls.append(button("edit-move", "Edit the move", () => ask("part", { ...part, id: "move-type" })));
  } else if (about.parameters.some((p) => p.name === "move.profile.0.angle")) {
    const list = element("select", { id: "move-type" }, ...["s_curve", "trapezoid"].map((value) => element("option", { value, textContent: value.replace("_", "-") })));
    if (kind) list.value = kind;
    list.addEventListener("change", () => ask("values", { [name]: list.value }));
    controls.append(...(kind ? [element("label", {}, "Profile ", list)] : []), "Set angle and time under move in the panel of values.");
  }
}

async function move() {
  const draw = pictures();
  moveControls();
  const r = await call("/api/move", { body: { state: asked() }, kind: "view" });
  const above = r.limit_arcsec !== null && r.peak_arcsec > r.limit_arcsec;
  answer(sentences(r.failures) + signed(r.said), r.limits.length ? r.passes && (above ? null : true) : null);
  const line = (y, name, unit, colour, more) => ({ x: r.time, y, mode: "lines", name, line: { color: colour, width: 2, ...more }, hovertemplate: `%{x:.4g} s<br>%{y:.4g} ${unit}<extra></extra>` });
  const over = (y, name, unit, colour, bound, bounds, middle = 0, begin = 0) => [line(y, name, unit, colour), ...(bound ? [1, -1].map((sign) => ({ ...line(r.time.map((t) => (t < begin ? null : middle + sign * bound)), bounds, unit, ORANGE, { width: 1.5, dash: "dash" }), showlegend: sign > 0 })) : [])];
  const end = { type: "line", xref: "x", yref: "paper", x0: r.duration, x1: r.duration, y0: 0, y1: 1, line: { color: PINK, width: 1.5, dash: "dot" } };
  const table = { "time [s]": r.time, "reference [deg]": r.reference_deg, "pointing error [arcsec]": r.error_arcsec, "motor torque [N*m]": r.motor_torque, "gear torque [N*m]": r.gear_torque, "motor speed [rpm]": r.motor_speed };
  const x = { title: "time [s]" };
  await draw("move-error", { data: [...over(r.error_arcsec, "pointing error", "arcsec", BLUE, r.window_arcsec, "settling window", r.rest_arcsec, r.duration), ...(r.limit_arcsec === null ? [] : over(r.error_arcsec, "", "", BLUE, r.limit_arcsec, "limit").slice(1).map((one) => ({ ...one, line: { ...one.line, color: GREEN, dash: "dot" } })))], layout: { shapes: [end], xaxis: x, yaxis: { title: "pointing error [arcsec]" } }, table, label: `Pointing error over the move, ${between(r.error_arcsec, "arcsec")}` });
  await draw("move-motor", { data: over(r.motor_torque, "motor torque", "N·m", BLUE, r.most_motor_torque, "largest torque of the motor"), layout: { shapes: [end], xaxis: x, yaxis: { title: "motor torque [N·m]" } }, table, label: `Torque of the motor over the move, ${between(r.motor_torque, "N·m")}`, size: "second" });
  await draw("move-torque", { data: over(r.gear_torque, "gear torque", "N·m", RED), layout: { showlegend: false, xaxis: x, yaxis: { title: "gear torque [N·m]" } }, table, label: `Torque in the gear over the move, ${between(r.gear_torque, "N·m")}`, size: "second" });
  await draw("move-speed", { data: over(r.motor_speed, "motor speed", "rpm", GREEN), layout: { showlegend: false, xaxis: x, yaxis: { title: "motor speed [rpm]" } }, table, label: `Speed of the motor over the move, ${between(r.motor_speed, "rpm")}`, size: "second" });
  link(["move-error", "move-motor", "move-torque", "move-speed"]);
  numbers(r.numbers);
  return r.remarks;
}

export const VIEWS = {
  response: { name: "Response", show: response }, motion: { name: "Motion at a speed", show: motion },
  move: { name: "Move", show: move }, "speed-map": { name: "Speed map", show: speedMap },
  compensation: { name: "Compensation", show: compensation },
  tuning: { name: "Tuning", show: tuning }, log: { name: "Log", show: log },
};

// A view as its script names it; one of a job that was not run is none.
function scripted({ view, options }, present) {
  const fast = ["response", "motion", "move"].includes(view), seen = { view: present || fast || options.run === view ? view : "" };
  if (view === "motion") seen.speed = Number(options.speed);
  return view === "speed-map" ? { ...seen, ...mapOptions(options) } : seen;
}

function script() {
  if (state.view === "log") throw new Error("a log has no Python script; use: strainwave identify PROJECT LOG");
  const before = session.slice(0, -1).filter((one) => one.view !== "log").slice(-200);
  return { state: asked(), ...scripted(state, true), before: before.map((one) => ({ values: one.values, ...scripted(one) })) };
}

export async function take(what) {
  if (what === "project") return download(stem() + ".yaml", await call("/api/export/project", { body: { state: asked() } }), "application/yaml");
  if (what === "script") return download(stem() + ".py", await call("/api/export/script", { body: script() }), "text/x-python");
  const one = await run("report", () => call("/api/jobs", { body: { state: asked(), kind: "report" } }));
  if (one.state === "failed") throw new Error(one.error);
  return one.state === "done" && download(stem() + ".html", one.result, "text/html");
}
