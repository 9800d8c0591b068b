// The page of the catalogue: the numbers of a gear in the axis of the sliders, and all gears in a table that sorts.

/** The numbers of a page with those of a gear; its motor is held at its speed, or free. */
function ofGear(data, numbers, [load, damping, drive], [gear, motor]) {
  const { ratio, inertia, fastest, law } = data.gears[gear], turning = ratio ** 2 * 1e-4 * (drive + 1e4 * inertia);
  const J = motor ? (load * turning) / (load + turning) : load;
  numbers.splice(0, 7 + law.length, J, 0, 0, J, 0, 0, 0.02 * damping * Math.sqrt(law[0] * J), ...law);
  numbers[numbers.length - 2] = Math.min(numbers.at(-2), fastest === null ? Infinity : fastest / data.scale);
  return numbers;
}

/** Project file of a gear in the axis of the sliders; its speeds end at the gear's largest. */
function projectOf(data, values, [gear, motor]) {
  const { name, inertia, fastest } = data.gears[gear], numbers = Object.fromEntries(data.sliders.map((slider, i) => [slider.name, values[i]]));
  numbers["motor.inertia"] += 1e4 * inertia;
  numbers["speed.to"] = Math.min(numbers["speed.to"], fastest ?? Infinity);
  const texts = { gear: name, mode: ["held", "free"][motor], ...Object.fromEntries(data.sliders.map((slider) => [slider.name, `${numbers[slider.name]} ${slider.unit}`])) };
  return data.project.replace(/@([a-z_.0]+)@/g, (_, key) => texts[key]);
}

/** What the table says of a gear: its record, and its answer in the axis of the sliders; a star where that is not whole. */
function rowOf(machine, data, values, gear, motor) {
  const { name, ratio, torque, fastest, law } = data.gears[gear], found = answered(machine, data, values, data.points, [gear, motor]), { scale } = data;
  const [J] = numbersAt(data, values, [gear, motor]), top = found.rows[found.top], resonance = (scale * Math.sqrt(law[0] / J)) / 2;
  const speeds = found.count <= 0 ? told(data, found)[0] : !top ? "no stable motion" : ranges(data, allowed(found), INWARD) || "none";
  const star = found.count > 0 && (found.others || found.tail > 1e-3 || !found.rows.every(decays)) ? " *" : "";
  return [name + star, ratio, torque, fastest, law[0] / 1e3, resonance, top ? top[1] / data.arcsec : null, speeds];
}

const byColumn = (column, way) => (one, other) => {
  const [a, b] = [one.cells[column], other.cells[column]];
  return a === b ? 0 : a === null ? 1 : b === null ? -1 : way * (typeof a === "string" ? a.localeCompare(b, "en", { numeric: true }) : a - b);
};
const table = { rows: [], column: 6, way: 1, timer: 0, of: "" };

/** After a pause compute all gears, some at a time; a gear that is chosen is marked. */
function gearsAt(machine, data, values, [chosen, motor], inputs) {
  const by = (id) => document.getElementById(id);
  const paint = () => {
    by("heads").replaceChildren(...data.columns.map((text, column) => {
      const button = element("button", { type: "button", textContent: text }), head = element("th", {}, button);
      if (column === table.column) head.setAttribute("aria-sort", table.way > 0 ? "ascending" : "descending");
      button.addEventListener("click", () => {
        [table.way, table.column] = [column === table.column ? -table.way : 1, column];
        paint();
        by("heads").children[column].firstChild.focus();
      });
      return head;
    }));
    by("rows").replaceChildren(...[...table.rows].sort(byColumn(table.column, table.way)).map(({ gear, cells: [name, ...more] }) => {
      const alone = data.gears[gear].name, button = element("button", { type: "button", textContent: alone });
      button.addEventListener("click", () => { inputs[0].value = gear; inputs[0].dispatchEvent(new Event("input")); scrollTo(0, 0); });
      const row = element("tr", {}, element("td", {}, button, name.slice(alone.length)), ...more.map((cell, i) => element("td", {}, cell === null ? "–" : typeof cell !== "number" ? cell : i < 4 ? short(cell) : sure(data, cell))));
      if (gear === inputs[0].selectedIndex) row.setAttribute("aria-current", "true");
      return row;
    }));
  };
  const of = JSON.stringify([values, motor]);
  give(by("file"), projectOf(data, values, [chosen, motor]));
  by("file").download = `${data.gears[chosen].name}.yaml`;
  clearTimeout(table.timer);
  if (of === table.of) return paint();
  inputs[data.choices.length + 2].disabled = !motor; // inertia of the motor
  table.of = "";
  by("all").className = "stale";
  const rows = [], slice = () => {
    const end = performance.now() + 30;
    while (rows.length < data.gears.length && performance.now() < end) rows.push({ gear: rows.length, cells: rowOf(machine, data, values, rows.length, motor) });
    by("progress").textContent = rows.length < data.gears.length ? `computing the gears: ${rows.length} of ${data.gears.length}` : "";
    if (rows.length < data.gears.length) return void (table.timer = setTimeout(slice));
    Object.assign(table, { rows, of });
    by("all").className = "";
    paint();
  };
  table.timer = setTimeout(slice, 300);
}
if (typeof document !== "object") module.exports = { ...module.exports, rowOf, projectOf };
