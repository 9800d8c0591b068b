// The views that a job fills: the map over speed and load, the compensation and the tuning.
import { call } from "/static/api.js";
import { jobView, outdated } from "/static/jobs.js";
import { answer, ask, between, BLUE, button, byId, element, GREEN, link, pictures, placed, RED, round, sentences, signed, tabled } from "/static/plots.js";
import { asked, state } from "/static/state.js";

const job = (body) => () => call("/api/jobs", { body: { state: asked(), ...body } });
const EDGE = [{ color: "#000", width: 5 }, { color: "#fff", width: 2 }]; // a line that is seen on every colour, and in grey
const heat = { colorscale: "Cividis", colorbar: { title: { text: "arcsec", side: "right" }, thickness: 14 } };

export async function speedMap() {
  const controls = byId("controls");
  if (!controls.childElementCount) {
    const search = element("input", { type: "checkbox", id: "search", checked: state.options.search !== "no" });
    search.addEventListener("change", () => { state.options.search = search.checked ? "yes" : "no"; outdated(); });
    const loads = element("input", { type: "text", id: "loads", value: state.options.loads ?? "", placeholder: "the project's, or -178; -89; 0", size: 26 });
    loads.addEventListener("input", () => { state.options.loads = loads.value; outdated(); });
    controls.append(element("label", {}, "Loads [N·m] ", loads), element("label", {}, search, " search for subharmonics and other motions at the same speed (longer computation)"));
  }
  return jobView(["Speeds that are allowed under each load.", "The oscillation over speed and load, forbidden speeds framed"], "Compute the speed map", () => {
    return { start: job({ kind: "speed-map", ...mapOptions() }) };
  }, paintSpeedMap);
}

// What is asked of the speed map. A comma between two digits may be a decimal one or not, and is asked about.
export function mapOptions(options = state.options) {
  const text = options.loads ?? "", texts = text.split(/[;,\s]+/).filter(Boolean), loads = texts.map(Number);
  const wrong = /\d,\d/.test(text) ? text.trim() : texts.find((_, i) => !Number.isFinite(loads[i]));
  if (wrong !== undefined) throw new Error(`loads: ${wrong} is not clear; write torques in N·m with semicolons between them, such as -89.5; -44; 0`);
  return { search: options.search !== "no", loads };
}

async function paintSpeedMap(r) {
  const draw = pictures();
  const failures = sentences(r.failures), framed = r.forbidden.some((bands) => bands.length) ? ` Framed: ${signed(r.rule).replace(/^forbidden if: /, "")}.` : "";
  answer(`${failures}${signed(r.said)}${framed}`, failures ? false : null);
  const steps = r.load.slice(1).map((load, i) => (load - r.load[i]) / 2), last = r.load.length - 1;
  const below = (i) => r.load[i] - (steps[Math.max(i - 1, 0)] ?? 0.5), above = (i) => r.load[i] + (steps[Math.min(i, last - 1)] ?? 0.5);
  const shapes = EDGE.flatMap((line) => r.forbidden.flatMap((bands, i) => bands.map(([low, high]) => ({ type: "rect", x0: low, x1: high, y0: below(i), y1: above(i), line }))));
  const cells = r.load.flatMap((load) => r.speed.map(() => load));
  await draw("speed-map", { data: [
    { type: "heatmap", x: r.speed, y: [...r.load.map((_, i) => below(i)), above(last)], z: r.oscillation_arcsec, ...heat, customdata: r.load.map((load) => r.speed.map(() => load)), hovertemplate: `%{x:.5g} ${r.speed_unit}<br>%{customdata:.4g} ${signed(r.load_unit)}<br>%{z:.4g} arcsec<extra></extra>` },
  ], layout: { showlegend: false, xaxis: { title: `${r.speed_name} [${r.speed_unit}]` }, yaxis: { title: `${r.load_name} [${signed(r.load_unit)}]`, tickvals: r.load, ticktext: r.load.map((load) => signed(round(load))) }, shapes }, table: { "load": cells, [`${r.speed_name} [${r.speed_unit}]`]: r.load.flatMap(() => r.speed), "oscillation [arcsec]": r.oscillation_arcsec.flat(), "gear torque [N*m]": r.torque.flat() }, label: `Oscillation over speed and load, ${between(r.oscillation_arcsec.flat(), "arcsec")}, with forbidden speeds framed` });
  return r.remarks;
}

export async function compensation() {
  return jobView(["The pointing error before and after compensation in the motor's loop, at the speed where the strongest order excites the resonance.", "Rms and peak of the pointing error, before and after", "The pointing error over time, before and after", "Rms error with softer and stiffer gears"], "Design and run", () => ({ start: job({ kind: "compensation" }) }), paintCompensation);
}

async function paintCompensation(r) {
  const draw = pictures();
  const kinds = [["rms_arcsec", "rms"], ["peak_arcsec", "peak incl. mean"]];
  const bar = (x, y, name, colour, pattern) => ({ type: "bar", name, x, y, text: y.map((value) => round(value, 3)), textposition: "outside", constraintext: "none", cliponaxis: false, marker: { color: colour, pattern: { shape: pattern } }, hovertemplate: "%{y:.4g} arcsec<extra>%{fullData.name}</extra>" });
  const pair = (x, before, after) => [bar(x, before, "before", RED, "/"), bar(x, after, "after", BLUE, "")];
  const texts = kinds.map(([, text]) => text), [before, after] = [r.before, r.after].map((one) => kinds.map(([key]) => one[key]));
  await draw("compensation", { data: pair(texts, before, after), layout: { barmode: "group", yaxis: { title: "pointing error [arcsec]" } }, table: { "quantity": texts, "before [arcsec]": before, "after [arcsec]": after }, label: signed(r.said) });
  const run = (y, name, color, dash) => ({ x: r.time.map((t) => 1e3 * t), y, mode: "lines", name, line: { color, dash }, hovertemplate: `%{x:.4g} ms<br>%{y:.4g} arcsec<extra>${name}</extra>` });
  await draw("compensation-time", { data: [run(r.before_arcsec, "before", RED, "dash"), run(r.after_arcsec, "after", BLUE, "solid")], layout: { xaxis: { title: "time [ms]" }, yaxis: { title: "pointing error [arcsec]" } }, table: { "time [s]": r.time, "before [arcsec]": r.before_arcsec, "after [arcsec]": r.after_arcsec }, label: `Pointing error over the last turns, before ${between(r.before_arcsec, "arcsec")}, after ${between(r.after_arcsec, "arcsec")}`, size: "second" });
  const gears = r.other_gears.map((g) => `${Math.abs(100 * g.stiffness)} % ${g.stiffness < 0 ? "softer" : "stiffer"}`);
  if (gears.length) {
    const names = [gears[0], "as the model", ...gears.slice(1)], at = (key) => [r.other_gears[0], { before_rms_arcsec: r.before.rms_arcsec, after_rms_arcsec: r.after.rms_arcsec }, ...r.other_gears.slice(1)].map((g) => g[key]);
    await draw("gears", { data: pair(names, at("before_rms_arcsec"), at("after_rms_arcsec")), layout: { barmode: "group", xaxis: { title: "stiffness of the gear" }, yaxis: { title: "rms [arcsec]" } }, table: { "gear": names, "before [arcsec]": at("before_rms_arcsec"), "after [arcsec]": at("after_rms_arcsec") }, label: signed(r.said), size: "second" });
  }
  answer(signed(r.said), r.excluded || !r.stable ? false : null);
  placed("prepend", element("div", { id: "assumed" }, "Assumed:", element("ul", {}, ...r.assumed.map((text) => element("li", { textContent: signed(text) })))));
  return r.remarks;
}

export async function tuning() {
  return jobView(["Loop gains that minimise the largest oscillation, within the margins and without worse compliance or settling time.", "Pointing: the oscillation over the speed, before and after", "Tracking: the load after a step of the reference, before and after", "Disturbance: the load after a step of torque on it, before and after"], "Tune the loop", () => ({ start: job({ kind: "tuning" }) }), paintTuning);
}

async function paintTuning(r) {
  const draw = pictures();
  const curve = (one, name, color, dash) => (one ? [{ x: one.speed, y: one.oscillation_arcsec, name, mode: "lines", line: { color, dash }, hovertemplate: `%{x:.5g} ${r.speed_unit}<br>%{y:.4g} arcsec<extra>${name}</extra>` }] : []);
  const limit = r.limit_arcsec !== null && r.after ? curve({ speed: [r.after.speed[0], r.after.speed.at(-1)], oscillation_arcsec: [r.limit_arcsec, r.limit_arcsec] }, "limit", GREEN, "dot") : [];
  const table = Object.fromEntries(["before", "after"].flatMap((key) => (r[key] ? [[`speed ${key} [${r.speed_unit}]`, r[key].speed], [`oscillation ${key} [arcsec]`, r[key].oscillation_arcsec]] : [])));
  await draw("tuning", { data: [...curve(r.before, "before", RED, "dash"), ...curve(r.after, "after", BLUE), ...limit], layout: { xaxis: { title: `speed [${r.speed_unit}]` }, yaxis: { title: "pointing: oscillation [arcsec, 0-to-peak]", rangemode: "tozero" } }, table, label: signed(r.said) });
  const step = (key, color, dash, part, unit) => ({ x: r.steps[key].time, y: r.steps[key][part], name: key, mode: "lines", line: { color, dash }, hovertemplate: `%{x:.4g} s<br>%{y:.4g} ${unit}<extra>${key}</extra>` });
  const stepped = async (name, part, title, unit, label) => {
    const columns = Object.fromEntries(["before", "after"].flatMap((key) => [[`time ${key} [s]`, r.steps[key].time], [`${title} ${key} [${unit || 1}]`, r.steps[key][part]]]));
    await draw(name, { data: [step("before", RED, "dash", part, unit), step("after", BLUE, "solid", part, unit)], layout: { xaxis: { title: "time [s]" }, yaxis: { title: unit ? `${title} [${unit}]` : title } }, table: columns, label: `${label}, after ${between(r.steps.after[part], unit)}` });
  };
  await stepped("tuning-reference", "reference", "tracking: speed of the load over its reference", "", "The load after a step of the reference");
  await stepped("tuning-torque", "torque", "disturbance: angle of the load", "arcsec/(N·m)", "The load after a step of torque on it");
  link(["tuning-reference", "tuning-torque"]);
  const shown = { oscillation_arcsec: "largest oscillation [arcsec]", settling_s: "settling after a torque step [s]", move_settling_s: "settling of the move [s]", compliance_arcsec_per_N_m: "compliance [arcsec per N·m]", peak_sensitivity: "peak sensitivity", gain_margin: "gain margin", phase_margin_deg: "phase margin [°]", motor_torque: "motor torque [N·m]" };
  const rows = [...Object.entries(r.gains).map(([name, unit], i) => [`${name} [${unit}]`, ...r.points.map((p) => round(p.gains[i]))]), ...Object.entries(shown).filter(([key]) => r.points.some((p) => p[key] !== null)).map(([key, text]) => [text, ...r.points.map((p) => round(p[key], 3))])];
  placed("prepend", element("div", { className: "wide", id: "tuned" }, tabled(["gains", ...r.points.map((p) => p.name)], rows), button("use", "Use these gains in the drive", () => ask("project", r.project))));
  answer(signed(r.said));
  return r.remarks;
}
