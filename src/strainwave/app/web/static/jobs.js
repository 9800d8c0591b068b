// Jobs: one for each view, and one for the report. They go on while another view is shown, and keep their results.
import { call, leave } from "/static/api.js";
import { answer, ask, button, byId, element, epoch, numbers } from "/static/plots.js";
import { asked, remember, state } from "/static/state.js";

const jobs = new Map();
const going = (one) => one?.state === "waiting" || one?.state === "running";
export const busy = (name) => going(jobs.get(name));
export const jobOf = (name) => jobs.get(name);
const tell = (name) => ask("job", name);
const drop = (one) => one.id && call("/api/jobs/" + one.id, { method: "DELETE" }).catch(() => {});
const drive = () => JSON.stringify(asked());

// Start a job and follow it; `start` asks the server for it. What has ended is told by its state.
export async function run(name, start, more = {}) {
  stop(name);
  const one = { ...more, drive: drive(), state: "waiting", stage: "waiting", share: 0, seconds_left: null };
  jobs.set(name, one);
  tell(name);
  try {
    one.id = (await start()).id;
    while (going(one)) {
      await new Promise((resolve) => setTimeout(resolve, 150));
      if (going(one)) Object.assign(one, await call("/api/jobs/" + one.id, { kind: "job " + name }));
      tell(name);
    }
  } catch (error) {
    if (going(one)) Object.assign(one, { state: "failed", error: error.message });
    tell(name);
  }
  if (!one.dropped) await drop(one);
  return one;
}

export function stop(name) {
  const one = jobs.get(name);
  if (!going(one)) return;
  one.state = "cancelled";
  leave("job " + name);
  one.dropped = Boolean(drop(one));
  tell(name);
}
export function forget(name) {
  stop(name);
  jobs.delete(name);
}
export const stopAll = () => [...jobs.values()].filter(going).forEach(drop);

export const progressOf = (one) => one.stage + (one.seconds_left === null ? "" : `, about ${Math.ceil(one.seconds_left)} s left`);

// The controls of a view that a job fills, and its picture. `begin` gives {start, ...more}.
export async function jobView([question, ...pictures], label, begin, paint) {
  const controls = byId("controls"), view = state.view;
  if (!controls.querySelector("#begin")) {
    const bar = element("progress", { max: 1, value: 0, id: "progress" });
    bar.setAttribute("aria-label", "progress");
    const stage = element("span", { id: "stage" });
    stage.setAttribute("aria-live", "polite");
    const start = button("begin", label, async () => {
      byId("status").textContent = "";
      try {
        const { start: asks, ...more } = begin();
        const one = await run(view, asks, more);
        if (one.state !== "done" || one.drive !== drive() || state.view !== view || view === "log") return;
        state.options.run = view; // the address is that of a computed picture
        await remember();
      } catch (error) {
        Object.assign(byId("status"), { textContent: error.message, className: "bad" });
      }
    });
    controls.append(start, button("cancel", "Cancel", () => stop(view)), bar, stage);
    if (state.options.run === view && !jobs.has(view)) start.click();
  }
  const one = jobs.get(view) ?? { state: "none", stage: "", share: 0, seconds_left: null };
  const changed = one.result && (one.drive !== drive() || one.outdated) && view !== "log";
  byId("begin").disabled = going(one);
  byId("cancel").disabled = !going(one);
  byId("progress").value = one.share;
  byId("stage").textContent = one.state === "failed" || one.state === "none" ? "" : one.state === "cancelled" ? "cancelled" : changed ? "the drive has changed; compute again" : progressOf(one);
  if (one.state === "failed") Object.assign(byId("status"), { textContent: one.error, className: "bad" });
  if (changed) {
    delete state.options.run;
    remember();
  }
  const result = one.result;
  byId("plots").classList.toggle("outdated", Boolean(changed) || going(one));
  if (!result && question) {
    answer(question);
    const awaited = pictures.map((textContent) => element("figure", { className: "awaited", textContent }));
    if (!document.querySelector(".plot")) byId("plots").replaceChildren(...awaited);
  }
  if (!result || (one.painted === result && one.epoch === epoch)) return one.remarks ?? [];
  Object.assign(one, { painted: result, epoch });
  document.querySelectorAll(".awaited").forEach((box) => box.remove());
  one.remarks = await paint(result, one);
  if (result.numbers) numbers(result.numbers);
  return one.remarks ?? [];
}

// What a control of the view asks has changed: the picture is not that of the controls any more.
export function outdated() {
  if (jobs.get(state.view)?.result) jobs.get(state.view).outdated = true;
  remember();
  tell(state.view);
}
