// The page of a drive: sliders move its numbers, the kernel answers, and the answer is drawn and told.

const bytes = (text) => Uint8Array.from(atob(text), (one) => one.charCodeAt(0));
const COLUMNS = 6, BANDS = 64, DECAYS = 1 - 1e-10, STEPS = 500;

/** Step of a slider that has the number of the file, and the number at a step. */
const home = (slider) => Math.round((STEPS * (slider.value - slider.low)) / (slider.high - slider.low));
const valueAt = (slider, step) => (step === home(slider) ? slider.value : slider.low + ((slider.high - slider.low) * step) / STEPS);

/** The numbers of the page at the values of its sliders. */
function numbersAt(data, values) {
  const numbers = [...data.numbers];
  data.sliders.forEach((slider, i) => slider.moves.forEach(([place, slope]) => (numbers[place] += slope * (values[i] - slider.value))));
  return numbers;
}

/** The answer of the kernel: points, bands, and what is known of them. */
function answered(machine, data, values, points) {
  const numbers = numbersAt(data, values), [J, B] = numbers, [low, high, limit] = numbers.slice(-3);
  if (!(low > 0 && low < high)) return { count: -4, rows: [], bands: [], harmonics: 0 };
  let next = 2;
  const place = {};
  for (const [name, words] of Object.entries(data.words)) {
    place[name] = machine.main.take(8 * words.length + 8);
    const memory = new DataView(machine.main.memory.buffer, place[name]);
    words.forEach((word, i) => typeof word === "string" ? memory.setBigInt64(8 * i, BigInt(word), true) : memory.setFloat64(8 * i, numbers[next++], true));
  }
  const at = (name) => addressOf(machine, name), e = data.exact, array = (...shape) => ({ shape, data: new Float64Array(shape.reduce((a, b) => a * b)) });
  const system = [J, B, low, place.law, [place.excitation, at("excitation")], [place.error, at("error")], array(1)];
  const law = [place.law, at("torques"), at("stiffnesses"), data.kinks ? at("breakpoints") : 0, data.kinks];
  const called = ["torques", "stiffness", "slack", "hill"].map((name) => at(name + e));
  const functions = [...called, at("equations"), at("jacobian"), at("slope"), e];
  const curve = array(data.mostPoints, COLUMNS), bands = array(BANDS, 2), about = array(5);
  const allowed = data.limited ? limit : Infinity;
  let count;
  try {
    count = run(machine, "answer", [system, 2, law, functions, low, high, allowed, points, data.harmonics, data.most, curve, bands, about]);
  } finally {
    Object.values(place).forEach((one) => machine.main.give(one));
  }
  const rows = Array.from({ length: Math.max(0, count) }, (_, i) => Array.from(curve.data.subarray(COLUMNS * i, COLUMNS * (i + 1))));
  const pairs = Array.from({ length: about.data[2] }, (_, i) => [bands.data[2 * i], bands.data[2 * i + 1]]);
  return { count, rows, bands: pairs, harmonics: about.data[0], tail: about.data[1], top: about.data[3], others: about.data[4] > 0, low, high, limit: allowed };
}

const short = (value) => Number(value.toPrecision(4)).toString();

/** Sentences of an answer, in the words and units of the project. */
function told(data, found) {
  const { facts, scale, speedUnit, arcsec } = data, fill = (key, text) => facts[key].replace("{}", text);
  if (found.count <= 0) return [facts[{ "-1": "lost", "-2": "turned", "-3": "unknown", "-4": "range" }[found.count] ?? "lost"]];
  const texts = [], top = found.rows[found.top], speed = (omega) => `${short(scale * omega)} ${speedUnit}`;
  if (top) texts.push(`${fill("largest.oscillation_arcsec", `${short(top[1] / arcsec)} arcsec`)} ${fill("largest.speed", speed(top[0]))}`);
  if (top) texts.push(fill("largest.torque_N_m", `${short(Math.max(...found.rows.filter((row) => row[3] < DECAYS).map((row) => row[4])))} ${data.units._N_m}`));
  if (data.limited) texts.push(found.bands.length ? fill("above", found.bands.map(([a, b]) => `${short(scale * a)} to ${speed(b)}`).join(", ")) : facts.none_above);
  if (found.rows.some((row) => row[3] >= DECAYS)) texts.push(facts.unstable);
  if (found.others) texts.push(facts.others);
  if (found.tail > 1e-3) texts.push(facts.tail);
  return texts;
}

/** The picture of an answer: oscillation over the speed, with the limit and the speeds above it. */
function drawn(data, found, width) {
  const W = Math.max(320, width), H = 0.53 * W, L = 64, R = 16, T = 14, D = 44, { scale, arcsec } = data;
  const most = 1.08 * Math.max(...found.rows.map((row) => row[1]), Number.isFinite(found.limit) ? found.limit : 0);
  const x = (omega) => L + ((omega - found.low) / (found.high - found.low)) * (W - L - R), y = (size) => H - D - (size / most) * (H - T - D);
  const steps = (top) => { const raw = top / 6, ten = 10 ** Math.floor(Math.log10(raw)); return [1, 2, 5, 10].map((one) => one * ten).find((one) => one >= raw); };
  const parts = [];
  for (const [a, b] of found.bands) parts.push(`<rect class="band" x="${x(a)}" y="${T}" width="${Math.max(1, x(b) - x(a))}" height="${H - T - D}"/>`);
  const across = steps(scale * (found.high - found.low)) * (W < 500 ? 2 : 1), up = steps(most / arcsec);
  for (let v = Math.ceil((scale * found.low) / across) * across; v <= scale * found.high; v += across)
    parts.push(`<line class="axis" x1="${x(v / scale)}" x2="${x(v / scale)}" y1="${T}" y2="${H - D}"/><text x="${x(v / scale)}" y="${H - D + 16}" text-anchor="middle">${short(v)}</text>`);
  for (let v = 0; v <= most / arcsec; v += up)
    parts.push(`<line class="axis" x1="${L}" x2="${W - R}" y1="${y(v * arcsec)}" y2="${y(v * arcsec)}"/><text x="${L - 6}" y="${y(v * arcsec) + 4}" text-anchor="end">${short(v)}</text>`);
  let at = 0;
  while (at < found.rows.length - 1) {
    const stable = (i) => found.rows[i][3] < DECAYS && found.rows[i + 1][3] < DECAYS, first = at, kind = stable(at);
    while (at < found.rows.length - 1 && stable(at) === kind) at++;
    const points = found.rows.slice(first, at + 1).map((row) => `${x(row[0]).toFixed(1)},${y(row[1]).toFixed(1)}`);
    parts.push(`<polyline class="${kind ? "stable" : "unstable"}" points="${points.join(" ")}"/>`);
  }
  if (Number.isFinite(found.limit)) parts.push(`<line class="limit" x1="${L}" x2="${W - R}" y1="${y(found.limit)}" y2="${y(found.limit)}"/>`);
  parts.push(`<text x="${(L + W - R) / 2}" y="${H - 6}" text-anchor="middle">${data.speedName} [${data.speedUnit}]</text>`);
  parts.push(`<text transform="translate(14 ${(T + H - D) / 2}) rotate(-90)" text-anchor="middle">oscillation [arcsec]</text>`);
  return `<svg viewBox="0 0 ${W} ${H}" role="img" aria-label="oscillation over the speed">${parts.join("")}</svg>`;
}

/** Whether this browser has the vectors that the kernels take. */
function hasVectors() {
  return typeof WebAssembly === "object" && WebAssembly.validate(new Uint8Array([0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 10, 1, 8, 0, 65, 0, 253, 15, 253, 98, 11]));
}

/** Build the sliders and answer whenever one moves; the address of the page holds their values. */
function show() {
  const by = (id) => document.getElementById(id), data = DATA;
  if (!hasVectors()) return void (by("said").textContent = data.facts.no_simd);
  const machine = start(bytes(KERNELS), data.kinds, bytes(OWN));
  by("file").href = URL.createObjectURL(new Blob([data.project]));
  const held = location.hash.slice(1).split("&").map(Number), inputs = [], outputs = [];
  data.sliders.forEach((slider, i) => {
    const label = document.createElement("label"), input = document.createElement("input"), output = document.createElement("output");
    Object.assign(input, { id: `slider${i}`, type: "range", min: 0, max: STEPS, value: home(slider) });
    if (held.length === data.sliders.length && Number.isFinite(held[i])) input.value = held[i];
    label.htmlFor = input.id;
    label.append(`${slider.label}: `, output, input);
    by("values").append(label);
    inputs.push(input), outputs.push(output);
  });
  const update = () => {
    const values = inputs.map((input, i) => valueAt(data.sliders[i], Number(input.value))), begun = performance.now();
    outputs.forEach((output, i) => inputs[i].setAttribute("aria-valuetext", (output.textContent = `${short(values[i])} ${data.sliders[i].unit}`)));
    const found = answered(machine, data, values, data.points), taken = performance.now() - begun;
    by("said").textContent = `${told(data, found).join("; ")}.`;
    by("picture").innerHTML = found.count > 0 ? drawn(data, found, by("picture").clientWidth) : "";
    by("how").textContent = `${found.count > 0 ? found.count : 0} steady motions by harmonic balance with ${found.harmonics} harmonics, in ${taken.toFixed(0)} ms.`;
    history.replaceState(null, "", `#${inputs.map((input) => input.value).join("&")}`);
  };
  inputs.forEach((input) => input.addEventListener("input", update));
  by("again").addEventListener("click", () => { inputs.forEach((input, i) => (input.value = home(data.sliders[i]))); update(); });
  update();
}
if (typeof document === "object") show();
else module.exports = { ...module.exports, answered, told };
