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
  if (found.others) texts.push(facts.others);
  if (found.tail > 1e-3) texts.push(facts.tail);
  if (data.gravity) texts.push(facts.gravity);
  return texts;
}

/** The picture of an answer: a quantity {column, size, name, limit} over the speed, with pinned curves and bands. */
function drawn(data, found, width, pins, { column, size, name, limit }) {
  const W = Math.max(320, width), H = Math.min(Math.max(0.53 * W, 240), 480), L = 64, R = 16, T = 14, D = 44, { scale } = data;
  const sizes = [found, ...pins].flatMap((one) => one.rows.map((row) => row[column] / size)), curve = Math.max(...sizes);
  const most = 1.08 * Math.max(curve, limit < 4 * curve ? limit : 0);
  const x = (omega) => (L + ((omega - found.low) / (found.high - found.low)) * (W - L - R)).toFixed(1), y = (v) => (H - D - (v / most) * (H - T - D)).toFixed(1);
  const steps = (top, count = 6) => { const raw = top / count, ten = 10 ** Math.floor(Math.log10(raw)); return [1, 2, 2.5, 5, 10].map((one) => one * ten).find((one) => one >= raw); };
  const parts = [];
  for (const [a, b] of found.bands) parts.push(`<rect class="band" x="${x(a)}" y="${T}" width="${Math.max(1, x(b) - x(a))}" height="${H - T - D}"/>`);
  const across = steps(scale * (found.high - found.low), W < 500 ? 4 : 6), up = steps(most);
  for (let v = Math.ceil((scale * found.low) / across) * across; v <= scale * found.high; v += across)
    parts.push(`<line class="axis" x1="${x(v / scale)}" x2="${x(v / scale)}" y1="${T}" y2="${H - D}"/><text x="${x(v / scale)}" y="${H - D + 16}" text-anchor="middle">${short(v)}</text>`);
  for (let v = 0; v <= most; v += up)
    parts.push(`<line class="axis" x1="${L}" x2="${W - R}" y1="${y(v)}" y2="${y(v)}"/><text x="${L - 6}" y="${Number(y(v)) + 4}" text-anchor="end">${short(v)}</text>`);
  const lines = (rows, kindOf) => {
    for (let at = 0; at < rows.length - 1; ) {
      const first = at, kind = kindOf(rows[at], rows[at + 1]);
      while (at < rows.length - 1 && kindOf(rows[at], rows[at + 1]) === kind) at++;
      parts.push(`<polyline class="${kind}" points="${rows.slice(first, at + 1).map((row) => `${x(row[0])},${y(row[column] / size)}`).join(" ")}"/>`);
    }
  };
  for (const one of pins) lines(one.rows.filter(([omega]) => omega >= found.low && omega <= found.high), () => "pin");
  lines(found.rows, (...two) => (decay(...two) ? "stable" : "unstable"));
  if (limit <= most) parts.push(`<line class="limit" x1="${L}" x2="${W - R}" y1="${y(limit)}" y2="${y(limit)}"/>`);
  parts.push(`<text x="${(L + W - R) / 2}" y="${H - 6}" text-anchor="middle">${data.speedName} [${data.speedUnit}]</text>`);
  parts.push(`<text transform="translate(14 ${(T + H - D) / 2}) rotate(-90)" text-anchor="middle">${name}</text>`);
  const told = `${name} over the ${data.speedName}, at most ${sure(data, Math.max(...found.rows.map((row) => row[column] / size)))}`;
  return `<svg viewBox="0 0 ${W} ${H}" role="img" aria-label="${told}" data-left="${L}" data-right="${W - R}">${parts.join("")}</svg>`;
}

/** Whether this browser has the vectors that the kernels take. */
const hasVectors = () => typeof DecompressionStream === "function" && typeof WebAssembly === "object" && WebAssembly.validate(new Uint8Array([0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 10, 1, 8, 0, 65, 0, 253, 15, 253, 98, 11]));

/** The motion of an answer next to the place of a pointer in a picture, in words. */
function pointed(data, found, svg, { clientX }) {
  const box = svg.getBoundingClientRect(), { left, right } = svg.dataset, share = ((clientX - box.left) * svg.viewBox.baseVal.width) / box.width;
  const omega = found.low + ((share - left) / (right - left)) * (found.high - found.low), away = ([at]) => Math.abs(at - omega);
  const [at, size, , , torque] = found.rows.reduce((best, row) => (away(row) < away(best) ? row : best));
  return `${sure(data, data.scale * at)} ${data.speedUnit}: ${sure(data, size / data.arcsec)} arcsec, ${sure(data, torque)} ${data.units._N_m}`;
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
  let found, pins = [];
  const quantities = [{ column: 1, size: data.arcsec, name: "oscillation [arcsec]" }, { column: 4, size: 1, name: `torque in the gear [${data.units._N_m}]` }];
  const draw = () => {
    const whole = by("pictures").clientWidth, width = whole > 60 * parseFloat(getComputedStyle(document.documentElement).fontSize) ? whole / 2 : whole, limits = [found.limit / data.arcsec, NaN];
    by("pictures").innerHTML = found.count > 0 ? quantities.map((one, i) => drawn(data, found, width, pins, { ...one, limit: limits[i] })).join("") : "";
    if (!alone) frameElement.style.height = `${document.documentElement.offsetHeight + 8}px`;
  };
  const update = () => {
    const chosen = inputs.slice(0, number).map((input) => input.selectedIndex);
    const values = data.sliders.map((slider, i) => valueAt(slider, Number(inputs[number + i].value))), begun = performance.now();
    outputs.forEach((output, i) => inputs[number + i].setAttribute("aria-valuetext", (output.textContent = `${short(values[i])} ${data.sliders[i].shown}`)));
    found = answered(machine, data, values, data.points, chosen);
    const taken = performance.now() - begun;
    by("said").textContent = `${told(data, found).join("; ")}.`;
    by("how").textContent = `${Math.max(0, found.count)} steady motions by harmonic balance with ${found.harmonics} harmonics, in ${taken.toFixed(0)} ms.`;
    draw();
    if (alone) history.replaceState(null, "", `#${inputs.map((input) => input.value).join("&")}`);
    if (data.gears) gearsAt(machine, data, values, chosen, inputs);
    else give(by("file"), fileOf(data, values));
  };
  inputs.forEach((input) => input.addEventListener("input", update));
  by("again").addEventListener("click", () => { inputs.forEach((input, i) => (input.value = homes[i])); update(); });
  by("pin").addEventListener("click", () => { pins = [...pins.slice(-3), found]; draw(); });
  by("unpin").addEventListener("click", () => { pins = []; draw(); });
  by("pictures").addEventListener("pointermove", (event) => event.target.closest("svg") && (by("how").textContent = pointed(data, found, event.target.closest("svg"), event)));
  addEventListener("resize", draw);
  update();
}
if (typeof document === "object") show();
else module.exports = { ...module.exports, answered, told, allowed, fileOf };
