"use strict";
// Kernels in WebAssembly: `start` makes them ready, `run` calls one with numbers and arrays, `answered` asks for a curve.

const COLUMNS = 6;

/** A machine of the bytes of the kernels, and of those of laws beside them; `kinds` are those of all arguments. */
const start = (bytes, kinds, laws) => renewed({ kinds, modules: [bytes, laws].map((code) => new WebAssembly.Module(code)) });

/** The machine with memory of its own, as after a kernel that ended in its middle: nothing gives back what that took. */
function renewed(machine) {
  const main = new WebAssembly.Instance(machine.modules[0], {}).exports;
  main._initialize();
  const beside = new WebAssembly.Instance(machine.modules[1], { env: { ...main, __linear_memory: main.memory } }).exports;
  const table = main.__indirect_function_table, functions = { ...main, ...beside };
  return Object.assign(machine, { main, table, functions, places: new Map() });
}

/** Address of a function for code that calls it: its place in the table. */
function addressOf(machine, name) {
  if (!machine.places.has(name)) {
    machine.places.set(name, machine.table.grow(1));
    machine.table.set(machine.places.get(name), machine.functions[name]);
  }
  return BigInt(machine.places.get(name));
}

/** Call a kernel that returns a whole number; arrays {shape, data} are copied to it and back. */
function run(machine, name, given) {
  const { main } = machine, taken = [], flat = [], arrays = [];
  const take = (size) => (taken.push(main.take(size)), taken.at(-1));
  const pass = (kind, value) => {
    if (Array.isArray(kind)) kind.forEach((one, i) => pass(one, value[i]));
    else if (kind === "f64") flat.push(value);
    else if (kind === "i64") flat.push(BigInt(value));
    else {
      const place = take(8 * value.data.length + 8), shape = value.shape.map(BigInt);
      arrays.push([place, value.data]);
      const steps = shape.map((_, i) => shape.slice(i + 1).reduce((a, b) => a * b, 8n));
      flat.push(0, 0, BigInt(value.data.length), 8n, place, ...shape, ...steps);
    }
  };
  const here = ([place, data]) => new data.constructor(main.memory.buffer, place, data.length);
  try {
    const result = take(16);
    machine.kinds[name].forEach((kind, i) => pass(kind, given[i]));
    for (const one of arrays) here(one).set(one[1]);
    const code = machine.functions[name](result, result + 8, ...flat);
    if (code) throw new WebAssembly.RuntimeError(`${name} ends with ${code}`);
    for (const one of arrays) one[1].set(here(one));
    const number = Number(new BigInt64Array(main.memory.buffer, result, 1)[0]);
    taken.forEach((place) => main.give(place));
    return number;
  } catch (error) {
    renewed(machine);
    throw error;
  }
}

/** The numbers of the page at the values of its sliders, and of the gear that is chosen where it has all of them. */
function numbersAt(data, values, chosen) {
  const numbers = [...data.numbers], { sliders } = data;
  sliders.forEach((slider, i) => slider.moves.forEach(([place, slope]) => (numbers[place] += slope * (values[i] - slider.value))));
  for (const [place, terms] of data.terms)
    numbers[place] = terms.reduce((sum, [factor, powers]) => sum + powers.reduce((term, [i, power]) => term * (values[i] / sliders[i].unity) ** power, factor), 0);
  return chosen.length ? ofGear(data, numbers, values, chosen) : numbers;
}

/** The answer of the kernel: points, bands, and what is known of them; none where the kernel ends in its middle. */
function answered(machine, data, values, points, chosen = []) {
  const numbers = numbersAt(data, values, chosen), [low, high, limit] = numbers.slice(-3), { laws, start } = data;
  const none = { count: -4, rows: [], bands: [], harmonics: 0 };
  if (!(low > 0 && low < high)) return none;
  let next = start;
  const array = (...shape) => ({ shape, data: new Float64Array(shape.reduce((a, b) => a * b, 1)) }), at = (name) => addressOf(machine, name);
  const parts = data.shapes.map((shape) => { const part = array(...shape); part.data.forEach((_, i) => (part.data[i] = numbers[next++])); return part; });
  const places = laws.map(({ words }, j) => {
    const place = machine.main.take(8 * words.length + 8), memory = new DataView(machine.main.memory.buffer, place);
    let number = 0;
    words.forEach((word, i) => typeof word === "string" ? memory.setBigInt64(8 * i, BigInt(word), true) : memory.setFloat64(8 * i, parts[3 + j].data[number++], true));
    return place;
  });
  const rows = laws.flatMap(({ kind, kinks, exact: e }, j) => [
    BigInt(places[j]), at(`torques_of_law${kind}`), at(`stiffnesses_of_law${kind}`), kinks ? at(`breakpoints_of_law${kind}`) : 0n, BigInt(kinks),
    ...["torques", "stiffness", "slack"].map((name) => at(name + e)), 0n, BigInt(e),
  ]);
  const [matrices, disturbed, damping] = parts, drive = [matrices, disturbed, ...parts.slice(3 + laws.length), damping.data[0], { shape: [laws.length, 10], data: BigInt64Array.from(rows) }, ...data.whole];
  const curve = array(data.mostPoints, COLUMNS), bands = array(data.mostPoints, 2), about = array(5), allowed = data.limited ? limit : Infinity;
  let count = -1;
  try {
    count = run(machine, "answer", [drive, ["equations", "jacobian", "slope"].map(at), low, high, allowed, points, ...data.begin, curve, bands, about]);
  } catch (error) {
    if (!(error instanceof WebAssembly.RuntimeError)) throw error;
    return { ...none, count }; // in memory of its own the machine has no places to give back
  }
  places.forEach((place) => machine.main.give(place));
  const found = Array.from({ length: Math.max(0, count) }, (_, i) => Array.from(curve.data.subarray(COLUMNS * i, COLUMNS * (i + 1))));
  const pairs = Array.from({ length: about.data[2] }, (_, i) => [bands.data[2 * i], bands.data[2 * i + 1]]);
  return { count, rows: found, bands: pairs, harmonics: about.data[0], tail: about.data[1], top: about.data[3], others: about.data[4] > 0, low, high, limit: allowed };
}
if (typeof module === "object") module.exports = { start, addressOf, run };
