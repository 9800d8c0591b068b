// The view of a log: what is in it, which column is what, and the drive that it identifies.
import { call } from "/static/api.js";
import { forget, jobView } from "/static/jobs.js";
import { answer, ask, between, BLUE, button, byId, clear, COLOURS, element, epoch, ORANGE, pictures, placed, RED, round, signed, tabled } from "/static/plots.js";
import { asked } from "/static/state.js";

let file = null, found = null, chosen = {}, painted = 0, remarks = []; // what was dropped, what is in it, and what was said of its columns
const query = () => `?name=${encodeURIComponent(file.name)}&columns=${encodeURIComponent(JSON.stringify(chosen))}`;

export async function readLog(dropped, columns = {}) {
  if (dropped.size > 20 * 1024 * 1024) throw new Error("the log is larger than 20 MiB; shorten it first");
  forget("log");
  [file, chosen, found, painted] = [dropped, columns, null, 0];
  found = await call("/api/log" + query(), { raw: file, kind: "view" });
}

// Which column is which channel, in which unit; as it is read, or as the visitor says.
function columnTable() {
  const boxes = found.columns.map((c, i) => {
    const place = Object.entries(chosen.columns ?? {}).find(([, at]) => at === i)?.[0] ?? (chosen.columns ? "" : c.channel);
    const list = element("select", {}, element("option", { value: "", textContent: "as named" }), ...found.as.map((name) => element("option", { value: name, textContent: name.replaceAll("_", " ") })));
    list.value = place;
    list.setAttribute("aria-label", `channel of column ${i + 1}`);
    const unit = element("input", { type: "text", size: 8, value: chosen.units?.[place] ?? "", placeholder: c.unit || "SI" });
    unit.setAttribute("aria-label", `unit of column ${i + 1}`);
    return { list, unit, row: [c.name || `column ${i + 1}`, list, unit] };
  });
  const rate = element("input", { type: "text", size: 8, value: chosen.rate ?? "", inputMode: "decimal" });
  const read = button("read-so", "Read with these columns", () => {
    const named = boxes.map((box, i) => [box.list.value, i, box.unit.value.trim()]).filter(([channel]) => channel);
    const units = Object.fromEntries(named.filter(([, , unit]) => unit).map(([channel, , unit]) => [channel, unit]));
    const columns = Object.fromEntries(named.map(([channel, i]) => [channel, i]));
    ask("log", { file, columns: { columns, units, ...(rate.value ? { rate: Number(rate.value.replace(",", ".")) } : {}) } });
  });
  return element("details", { id: "columns", open: Boolean(found.why) }, element("summary", {}, "Columns of the log"), element("div", { className: "wide" }, tabled(["column", "channel", "unit"], boxes.map((box) => box.row))), element("p", {}, element("label", {}, "Samples per second (log without time) ", rate), " ", read));
}

export async function log() {
  const controls = byId("controls");
  if (!controls.childElementCount) {
    const input = element("input", { type: "file", id: "log-file", accept: ".csv,.txt,.dat,.npz,.mat,.parquet,.mf4,.mcap" });
    input.addEventListener("change", () => input.files[0] && ask("log", { file: input.files[0] }));
    controls.append(element("label", { className: "drop" }, "Drop a CSV, npz, mat, parquet or mf4 file here, or choose one: ", input));
  }
  if (!found) {
    answer("Drop a log onto the page to see its channels, sections of constant speed and orders.");
    return [];
  }
  if (painted !== epoch) remarks = await paintLog(found);
  const names = (found.channels ?? []).map((c) => c.name);
  if (!names.includes("motor_angle") || !names.includes("load_angle")) return remarks;
  const more = await jobView([""], "Identify the drive", () => {
    const body = new Blob([JSON.stringify({ state: asked() }), "\n", file]);
    return { start: () => call("/api/identify" + query(), { raw: body }) };
  }, paintIdentified);
  return more.length ? more : remarks;
}

async function paintLog(r) {
  clear();
  painted = epoch;
  const draw = pictures();
  for (const id of ["begin", "cancel", "progress", "stage"]) byId(id)?.remove();
  const plots = byId("plots");
  plots.append(columnTable());
  if (r.why) {
    answer(`${file.name} cannot be read yet: ${r.why}`, false);
    return [];
  }
  answer(`${file.name}: ${r.said}, ${r.channels.length} channels${r.ratio === null ? "" : `, ratio ${round(r.ratio)}`}.`);
  const rows = r.orders.lines.map((l) => [round(l.order), `${round(l.amplitude)} ± ${round(l.error, 2)} ${signed(r.orders.unit)}`, l.kind]);
  const head = ["order", `amplitude of ${(r.orders.of ?? "").replaceAll("_", " ")}`, "kind"];
  const names = r.channels.map((c) => c.name), both = names.includes("motor_angle") && names.includes("load_angle");
  plots.append(element("div", { className: "wide" }, rows.length ? tabled(head, rows, { id: "orders" }) : element("p", { textContent: both ? "" : r.orders.why })));
  for (const [i, c] of [...(r.pointing ? [r.pointing] : []), ...r.channels].slice(0, 6).entries()) {
    await draw("log-" + c.name, { data: [{ x: r.time, y: c.values, mode: "lines", name: c.name, line: { color: COLOURS[i % COLOURS.length] }, hovertemplate: `%{x:.6g} s<br>%{y:.5g} ${signed(c.unit)}<extra></extra>` }], layout: { showlegend: false, xaxis: { title: "time [s]" }, yaxis: { title: `${c.name.replaceAll("_", " ")} [${signed(c.unit)}]` } }, table: { "time [s]": r.time, [`${c.name} [${c.unit}]`]: c.values }, label: `${c.name.replaceAll("_", " ")} over time, ${between(c.values, c.unit)}`, size: "second" });
  }
  const without = "Stiffness, damping and kinematic error require both motor_angle and load_angle. This log has only one of them, so only orders are shown.";
  return both ? r.notes : [without, ...r.notes];
}

async function paintIdentified(r) {
  const draw = pictures();
  const numbers = r.numbers.map((n) => [n.name, `${signed(round(n.value, 5))} ${n.unit}`, signed(`${round(n.low, 5)} to ${round(n.high, 5)}`)]);
  const table = tabled(["number", "found", "95 % interval"], numbers, { id: "identified" });
  const use = button("use", "Use these numbers in the drive", () => ask("project", r.project), { disabled: !r.usable });
  placed("prepend", element("div", { className: "wide", id: "identified-drive" }, table, use));
  const over = (y, name, colour, dash) => ({ x: r.time, y, mode: "lines", name, line: { color: colour, width: 1.5, dash }, hovertemplate: "%{x:.4g} s<br>%{y:.4g} arcsec<extra>%{fullData.name}</extra>" });
  const columns = { "time [s]": r.time, "measured torsion [arcsec]": r.measured_arcsec, "computed torsion [arcsec]": r.computed_arcsec, "residual [arcsec]": r.residual_arcsec };
  await draw("identified-torsion", { data: [over(r.measured_arcsec, "measured", BLUE, "solid"), over(r.computed_arcsec, "computed", RED, "dash")], layout: { xaxis: { title: "time [s]" }, yaxis: { title: "torsion [arcsec]" } }, table: columns, label: `Measured and computed torsion over time, measured ${between(r.measured_arcsec, "arcsec")}` });
  await draw("identified-residual", { data: [over(r.residual_arcsec, "residual", ORANGE, "solid")], layout: { showlegend: false, xaxis: { title: "time [s]" }, yaxis: { title: "residual [arcsec]" } }, table: columns, label: `Residual of the torsion over time, ${between(r.residual_arcsec, "arcsec")}`, size: "second" });
  answer(r.headline, r.usable ? null : false);
  return r.remarks;
}
