// The page of a drive: sliders move its numbers, the kernel answers, and the answer is drawn and told.

const bytes = (text) => Uint8Array.from(atob(text), (one) => one.charCodeAt(0));
const unpacked = async (text) => new Uint8Array(await new Response(new Blob([bytes(text)]).stream().pipeThrough(new DecompressionStream("gzip"))).arrayBuffer());
const DECAYS = 1 - 1e-10, FOLD = 2, STEPS = 500;

/** Step of a slider that has the number of the file, and the number at a step; one above zero goes by ratios. */
const home = ({ low, high, value }) => Math.round(STEPS * (low > 0 ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low)));
function valueAt(slider, step) {
  const { low, high, value } = slider;
  return step === home(slider) ? value : low > 0 ? low * (high / low) ** (step / STEPS) : low + ((high - low) * step) / STEPS;
}

const short = (value, digits = 4) => Number(value.toPrecision(digits)).toString();
/** A number of an answer: of as many digits as what it rests on, and never coarser than to 1. */
const sure = ({ digits }, value) => (Math.abs(value) >= 10 ** digits ? String(Math.round(value)) : short(value, digits));
const OUTWARD = [Math.floor, Math.ceil], INWARD = [Math.ceil, Math.floor];

/** An end of a band, rounded to one side by Math.floor or Math.ceil, and never coarser than to 1. */
function toward(way, value, digits) {
  const step = 10 ** Math.min(0, Math.floor(Math.log10(value)) + 1 - digits), steps = value / step, near = Math.round(steps);
  return Number(((Math.abs(steps - near) < 1e-6 ? near : way(steps)) * step).toPrecision(12));
}

/** Bands of speeds in words, each end to the side of its way; a band between two numbers that are printed is none. */
function ranges({ scale, digits }, bands, [from, to]) {
  const ends = bands.map(([a, b]) => [toward(from, scale * a, digits), toward(to, scale * b, digits)]);
  return ends.filter(([a, b]) => a < b).map(([a, b]) => `${a} to ${b}`).join(", ");
}

/** Whether a motion decays after a disturbance, and whether motions do between two points of a curve. */
const decays = (row) => row[3] < DECAYS, decay = (...two) => two.some(decays) && two.every((row) => decays(row) || row[5] === FOLD);

/** Whether a motion neither decays nor grows, apart from a fold: nothing holds its mean in a gap. */
const floats = (row) => row[5] !== FOLD && Math.abs(row[3] - 1) < 1 - DECAYS;

/** Speeds of a range outside bands of it. */
function outside({ low, high }, bands) {
  const gaps = [];
  let end = low;
  for (const [a, b] of [...[...bands].sort(([one], [other]) => one - other), [high, high]]) {
    if (a > end * (1 + 1e-6)) gaps.push([end, a]);
    end = Math.max(end, b);
  }
  return gaps;
}

/** Speeds at which no motion of a curve is stable. */
function unstableSpeeds(found) {
  const pairs = found.rows.slice(1).map((row, i) => [found.rows[i], row]).filter((two) => decay(...two));
  return outside(found, pairs.map(([[a], [b]]) => [Math.min(a, b), Math.max(a, b)]));
}

/** Speeds at which a motion is stable and none that is exceeds the limit. */
const allowed = (found) => outside(found, [...found.bands, ...unstableSpeeds(found)]);

/** Sentences of an answer, in the words and units of the project. */
function told(data, found) {
  const { facts, scale, speedUnit, arcsec } = data, fill = (key, text) => facts[key].replace("{}", text);
  if (found.count <= 0) return [facts[{ "-1": "lost", "-2": "turned", "-3": "unknown", "-4": "range" }[found.count] ?? "lost"]];
  const texts = [], top = found.rows[found.top], speed = (omega) => `${sure(data, scale * omega)} ${speedUnit}`;
  if (top) texts.push(`${fill("largest.oscillation_arcsec", `${sure(data, top[1] / arcsec)} arcsec`)} ${fill("largest.speed", speed(top[0]))}`);
  if (top) texts.push(fill("largest.torque_N_m", `${sure(data, Math.max(...found.rows.filter(decays).map((row) => row[4])))} ${data.units._N_m}`));
  const unstable = unstableSpeeds(found), say = (key, bands, ways) => { const text = ranges(data, bands, ways); if (text) texts.push(fill(key, `${text} ${speedUnit}`)); };
  if (data.limited && !found.bands.length && !unstable.length) texts.push(facts.none_above);
  else if (data.limited) { say("above", found.bands, OUTWARD); say("allowed", allowed(found), INWARD); }
  say("none_stable", unstable, OUTWARD);
  if (!found.rows.every(decays)) texts.push(facts.unstable);
  if (found.rows.filter(floats).length > 2) texts.push(facts.floats);
  if (found.others) texts.push(facts.others);
  if (found.tail > 1e-3) texts.push(facts.tail);
  if (data.gravity) texts.push(facts.gravity);
  return texts;
}

/** Sentences of what is computed after a pause: the curve of a held motor, and the map. */
function toldLater(data, { found, held, answers, loads }) {
  const { facts, scale, speedUnit, arcsec } = data, texts = [], top = held?.rows[held.top], free = outside(found, answers.flatMap((one) => forbidden(found, one)));
  if (top) texts.push(facts.held.replace("{}", `${sure(data, top[1] / arcsec)} arcsec at ${sure(data, scale * top[0])} ${speedUnit}`));
  if (answers.length) texts.push(facts.map);
  const span = answers.length ? `${short(loads[0])} to ${short(loads.at(-1))} ${data.units._N_m}` : "", speeds = ranges(data, free, INWARD);
  if (span && data.limited) texts.push(facts.loads.replace("{}", span).replace("{}", speeds ? `${speeds} ${speedUnit}` : "none"));
  return texts;
}

/** Axes over the speed of a quantity from `least` to `most`: places of both, the parts so far, and the whole of a picture. */
function axes({ scale, speedName, speedUnit }, { low, high }, width, [least, most], name) {
  const W = Math.max(320, width), H = Math.min(Math.max(0.53 * W, 240), 480), L = 64, R = 16, T = 14, D = 44, parts = [];
  const x = (omega) => (L + ((omega - low) / (high - low)) * (W - L - R)).toFixed(1), y = (v) => (H - D - ((v - least) / (most - least)) * (H - T - D)).toFixed(1);
  const steps = (top, count = 6) => { const raw = top / count, ten = 10 ** Math.floor(Math.log10(raw)); return [1, 2, 2.5, 5, 10].map((one) => one * ten).find((one) => one >= raw); };
  const across = steps(scale * (high - low), W < 500 ? 4 : 6), up = steps(most - least);
  for (let v = Math.ceil((scale * low) / across) * across; v <= scale * high; v += across)
    parts.push(`<line class="axis" x1="${x(v / scale)}" x2="${x(v / scale)}" y1="${T}" y2="${H - D}"/><text x="${x(v / scale)}" y="${H - D + 16}" text-anchor="middle">${short(v)}</text>`);
  for (let i = Math.ceil(least / up); i * up <= most; i++)
    parts.push(`<line class="axis" x1="${L}" x2="${W - R}" y1="${y(i * up)}" y2="${y(i * up)}"/><text x="${L - 6}" y="${Number(y(i * up)) + 4}" text-anchor="end">${short(i * up)}</text>`);
  parts.push(`<text x="${(L + W - R) / 2}" y="${H - 6}" text-anchor="middle">${speedName} [${speedUnit}]</text>`);
  parts.push(`<text transform="translate(14 ${(T + H - D) / 2}) rotate(-90)" text-anchor="middle">${name}</text>`);
  const box = (kind, [a, b], from, to, more = "") => parts.push(`<rect class="${kind}" x="${x(a)}" y="${y(to)}" width="${Math.max(1, x(b) - x(a))}" height="${y(from) - y(to)}"${more}/>`);
  const line = (kind, v) => parts.push(`<line class="${kind}" x1="${L}" x2="${W - R}" y1="${y(v)}" y2="${y(v)}"/>`);
  const picture = (told, more = "") => `<svg viewBox="0 0 ${W} ${H}" role="img" aria-label="${told}" data-left="${L}" data-right="${W - R}" data-top="${T}" data-bottom="${H - D}"${more}>${parts.join("")}</svg>`;
  return { x, y, parts, box, line, picture };
}

/** The picture of an answer: a quantity {column, size, name, limit} over the speed, with pinned curves, bands, and the curve of a held motor. */
function drawn(data, found, width, pins, { column, size, name, limit, held }) {
  const top = (one) => Math.max(...one.rows.map((row) => row[column] / size)), curve = Math.max(...[found, ...pins].map(top));
  const most = 1.08 * Math.max(curve, ...[limit, held ? top(held) : 0].filter((one) => one < 4 * curve));
  const { x, y, parts, box, line, picture } = axes(data, found, width, [0, most], name);
  for (const band of found.bands) box("band", band, 0, most);
  const lines = (rows, kindOf, more = "") => {
    for (let at = 0; at < rows.length - 1; ) {
      const first = at, kind = kindOf(rows[at], rows[at + 1]);
      while (at < rows.length - 1 && kindOf(rows[at], rows[at + 1]) === kind) at++;
      parts.push(`<polyline class="${kind}" points="${rows.slice(first, at + 1).map((row) => `${x(row[0])},${y(row[column] / size)}`).join(" ")}"${more}/>`);
    }
  };
  for (const one of pins) lines(one.rows.filter(([omega]) => omega >= found.low && omega <= found.high), () => "pin");
  if (held) {
    parts.push('<clipPath id="inside">');
    box("", [found.low, found.high], 0, most);
    parts.push("</clipPath>");
    lines(held.rows, () => "held", ' clip-path="url(#inside)"');
  }
  lines(found.rows, (...two) => (decay(...two) ? "stable" : "unstable"));
  if (limit <= most) line("limit", limit);
  return picture(`${name} over the ${data.speedName}, at most ${sure(data, top(found))}`);
}

const LOADS = 9, CELLS = 60;

/** Speeds of a range at which an answer allows none: above the limit, without a stable motion, or without an answer. */
const forbidden = (found, one) => (one.count > 0 ? outside(found, allowed(one)) : [[found.low, found.high]]);

/** The map of load torques over the speed: the largest stable oscillation by its shade, and the speeds that are forbidden. */
function mapped(data, { found, answers, loads }, width, load) {
  const half = (loads[1] - loads[0]) / 2, span = [loads[0] - half, loads.at(-1) + half], step = (found.high - found.low) / CELLS;
  const { box, line, picture } = axes(data, found, width, span, `load torque [${data.units._N_m}]`);
  const cells = answers.map(({ rows }) => {
    const sizes = Array(CELLS).fill(0), cell = (omega) => Math.min(CELLS - 1, Math.max(0, Math.floor((omega - found.low) / step)));
    rows.slice(1).forEach((row, i) => {
      if (!decay(rows[i], row)) return;
      const [first, last] = [cell(rows[i][0]), cell(row[0])].sort((a, b) => a - b);
      for (let j = first; j <= last; j++) sizes[j] = Math.max(sizes[j], rows[i][1], row[1]);
    });
    return sizes;
  });
  const most = Math.max(...cells.flat());
  answers.forEach((one, i) => {
    cells[i].forEach((size, j) => box("cell", [found.low + j * step, found.low + (j + 1) * step], loads[i] - half, loads[i] + half, ` opacity="${(size / most || 0).toFixed(2)}"`));
    for (const band of forbidden(found, one)) box("forbidden", band, loads[i] - half, loads[i] + half);
  });
  line("limit", load);
  return picture(`largest oscillation over the ${data.speedName} and the load torque`, ' id="map"');
}

/** Whether this browser has the vectors that the kernels take. */
const hasVectors = () => typeof DecompressionStream === "function" && typeof WebAssembly === "object" && WebAssembly.validate(new Uint8Array([0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 10, 1, 8, 0, 65, 0, 253, 15, 253, 98, 11]));

/** The motion of an answer next to the place of a pointer in a picture, in words. */
function pointed(data, found, svg, { clientX }) {
  const box = svg.getBoundingClientRect(), { left, right } = svg.dataset, share = ((clientX - box.left) * svg.viewBox.baseVal.width) / box.width;
  const omega = found.low + ((share - left) / (right - left)) * (found.high - found.low), away = ([at]) => Math.abs(at - omega);
  if (found.count <= 0) return told(data, found)[0];
  const [at, size, , , torque] = found.rows.reduce((best, row) => (away(row) < away(best) ? row : best));
  return `${sure(data, data.scale * at)} ${data.speedUnit}: ${sure(data, size / data.arcsec)} arcsec, ${sure(data, torque)} ${data.units._N_m}`;
}

/** The row of a map under a pointer, of some rows from below. */
function rowAt(svg, { clientY }, rows) {
  const box = svg.getBoundingClientRect(), { top, bottom } = svg.dataset, height = ((clientY - box.top) * svg.viewBox.baseVal.height) / box.height;
  return Math.min(rows - 1, Math.max(0, Math.floor((rows * (bottom - height)) / (bottom - top))));
}

const element = (tag, fields, ...children) => { const made = Object.assign(document.createElement(tag), fields); made.append(...children); return made; };

/** Project file with the numbers of the sliders; that of the drive where none is moved. */
function fileOf({ project, content, gear, sliders }, values) {
  const file = structuredClone(content), moved = sliders.map(({ value }, i) => values[i] !== value);
  if (!moved.includes(true)) return project;
  sliders.forEach(({ keys, unit }, i) => {
    if (!moved[i]) return;
    if (keys[1] === "law" && !file.gear.law) file.gear = structuredClone(gear);
    keys.slice(0, -1).reduce((group, key) => (group[key] ??= {}), file)[keys.at(-1)] = `${values[i]} ${unit}`.trim();
    if (file.sources) file.sources[keys.join(".")] = "yours";
  });
  return JSON.stringify(file, null, 1);
}

const give = (link, text) => { URL.revokeObjectURL(link.href); link.href = URL.createObjectURL(new Blob([text])); };

/** Build the choices and sliders and answer whenever one moves; the address of the page holds them. */
async function show() {
  const by = (id) => document.getElementById(id), data = DATA, alone = location.protocol !== "about:"; // else in a report
  if (!hasVectors()) return void (by("said").textContent = data.facts.no_simd);
  const machine = start(await unpacked(KERNELS), data.kinds, bytes(LAWS)), choices = data.choices ?? [], number = choices.length;
  if (!alone) by("file").after(" ", element("a", { textContent: "This page as a file", download: `${data.title}.html`, href: URL.createObjectURL(new Blob([frameElement.srcdoc], { type: "text/html" })) }));
  const outputs = data.sliders.map(() => element("output", {}));
  const inputs = [
    ...choices.map(({ options }) => element("select", {}, ...options.map((text, value) => element("option", { value }, text)))),
    ...data.sliders.map(() => element("input", { type: "range", min: 0, max: STEPS })),
  ];
  const homes = [...choices.map(({ value }) => value), ...data.sliders.map(home)], held = location.hash.slice(1).split("&").map(Number);
  const whole = held.length === inputs.length && held.every(Number.isInteger);
  inputs.forEach((input, i) => {
    const { label } = [...choices, ...data.sliders][i];
    input.id = `input${i}`;
    input.value = whole ? held[i] : homes[i];
    if (input.selectedIndex === -1) input.value = homes[i];
    by("values").append(element("label", { htmlFor: input.id }, ...(i < number ? [label] : [`${label}: `, outputs[i - number]]), input));
  });
  let found, pins = [], values, later = { timer: 0, answers: [] };
  const torque = data.sliders.findIndex(({ name }) => name === data.torque);
  const quantities = [{ column: 1, size: data.arcsec, name: "oscillation [arcsec]" }, { column: 4, size: 1, name: `torque in the gear [${data.units._N_m}]` }];
  const draw = () => {
    const whole = by("pictures").clientWidth, columns = whole > 60 * parseFloat(getComputedStyle(document.documentElement).fontSize) ? 2 : 1, width = whole / columns, limits = [found.limit / data.arcsec, NaN];
    const { held, answers } = later, fresh = later.found === found;
    by("pictures").style.gridTemplateColumns = `repeat(${columns}, minmax(0, 1fr))`;
    by("pictures").innerHTML = (found.count > 0 ? quantities.map((one, i) => drawn(data, found, width, pins, { ...one, limit: limits[i], held: fresh && i === 0 ? held : null })).join("") : "") + (answers.length ? mapped(data, later, width, values[torque]) : "");
    by("map")?.classList.toggle("stale", !fresh);
    by("later").textContent = fresh ? toldLater(data, later).join("; ").replace(/.$/, "$&.") : "";
    if (!alone) frameElement.style.height = `${document.documentElement.offsetHeight + 8}px`;
  };
  const after = () => {
    const answers = [], { low, high } = data.sliders[torque] ?? {}, loads = Array.from({ length: low < high ? LOADS : 0 }, (_, i) => low + ((high - low) * i) / (LOADS - 1));
    let held;
    return function slice() {
      const end = performance.now() + 30;
      if (data.held) held ??= answered(machine, { ...data, ...data.held }, values, data.held.points);
      while (answers.length < loads.length && performance.now() < end) answers.push(answered(machine, data, values.map((value, i) => (i === torque ? loads[answers.length] : value)), data.points));
      if (answers.length < loads.length) return void (later.timer = setTimeout(slice));
      later = { timer: 0, found, held: held?.count > 0 ? held : null, answers: found.low < found.high ? answers : [], loads };
      draw();
    };
  };
  const update = () => {
    const chosen = inputs.slice(0, number).map((input) => input.selectedIndex);
    values = data.sliders.map((slider, i) => valueAt(slider, Number(inputs[number + i].value)));
    const begun = performance.now();
    outputs.forEach((output, i) => inputs[number + i].setAttribute("aria-valuetext", (output.textContent = `${short(values[i])} ${data.sliders[i].shown}`)));
    found = answered(machine, data, values, data.points, chosen);
    const taken = performance.now() - begun;
    by("said").textContent = `${told(data, found).join("; ")}.`;
    by("how").textContent = `${Math.max(0, found.count)} steady motions by harmonic balance with ${found.harmonics} harmonics, in ${taken.toFixed(0)} ms.`;
    draw();
    if (alone) history.replaceState(null, "", `#${inputs.map((input) => input.value).join("&")}`);
    clearTimeout(later.timer);
    if (data.gears) return gearsAt(machine, data, values, chosen, inputs);
    give(by("file"), fileOf(data, values));
    later.timer = setTimeout(after(), 300);
  };
  inputs.forEach((input) => input.addEventListener("input", update));
  by("again").addEventListener("click", () => { inputs.forEach((input, i) => (input.value = homes[i])); update(); });
  by("pin").addEventListener("click", () => { pins = [...pins.slice(-3), found]; draw(); });
  by("unpin").addEventListener("click", () => { pins = []; draw(); });
  by("pictures").addEventListener("pointermove", (event) => {
    const svg = event.target.closest("svg");
    if (!svg) return;
    if (svg.id !== "map") return void (by("how").textContent = pointed(data, found, svg, event));
    const { loads, answers } = later, i = rowAt(svg, event, loads.length);
    by("how").textContent = `${sure(data, loads[i])} ${data.units._N_m}: ${pointed(data, answers[i], svg, event)}`;
  });
  addEventListener("resize", draw);
  update();
}
if (typeof document === "object") show();
else module.exports = { ...module.exports, answered, told, allowed, fileOf };
