"use strict";
// Kernels in WebAssembly: `start` makes them ready, `run` calls one with numbers and arrays.

/** A machine of the bytes of the kernels, and of a law of its own beside them; `kinds` are those of all arguments. */
function start(bytes, kinds, own) {
  const main = new WebAssembly.Instance(new WebAssembly.Module(bytes), {}).exports;
  main._initialize();
  const table = main.__indirect_function_table, machine = { main, table, kinds, functions: { ...main }, places: new Map() };
  if (own) {
    const env = { ...main, __linear_memory: main.memory };
    const beside = new WebAssembly.Instance(new WebAssembly.Module(own), { env }).exports;
    Object.assign(machine.functions, beside);
  }
  return machine;
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
  const result = take(16);
  machine.kinds[name].forEach((kind, i) => pass(kind, given[i]));
  for (const [place, data] of arrays) new Float64Array(main.memory.buffer, place, data.length).set(data);
  const code = machine.functions[name](result, result + 8, ...flat);
  for (const [place, data] of arrays) data.set(new Float64Array(main.memory.buffer, place, data.length));
  const number = Number(new BigInt64Array(main.memory.buffer, result, 1)[0]);
  taken.forEach((place) => main.give(place));
  if (code) throw new Error(`${name} ends with ${code}`);
  return number;
}
if (typeof module === "object") module.exports = { start, addressOf, run };
