// The history of the page: drives before and after the present one, for Undo and Redo, and the actions that a script repeats.

const PAUSE = 700; // ms without a change, after which the next change is one of its own for Back and Undo
const past = [], future = [];
export const BACK = [past, future], FORTH = [future, past];
export let session = []; // actions since the drive was opened: changed values, view and its options
let opened = "", drive = null, pausing = true, timer = 0;

// The next change begins an entry of its own.
export const settle = () => { pausing = true; };

// Note the state: its drive for Undo, its action for a script. Whether a change begins with it, after a pause.
export function noteChange(state, moved) {
  const { gear, project, values } = state;
  const now = JSON.stringify({ gear, project, values }), begins = pausing && drive !== null;
  noteAction(state);
  if (now !== drive && begins) {
    past.push(drive);
    future.length = 0;
  }
  if (moved || now !== drive) pausing = false;
  drive = now;
  clearTimeout(timer);
  timer = setTimeout(pause, PAUSE);
  return begins;
}

// A further change of the same view takes the place of the action before it, until a pause.
function noteAction({ gear, project, values, view, options }) {
  const origin = String(project ?? gear);
  if (opened !== origin) session = [];
  opened = origin;
  const last = session.at(-1), sameValues = last && JSON.stringify(last.values) === JSON.stringify(values);
  if (last?.view === view && (!pausing || sameValues)) session.pop();
  session.push({ values: { ...values }, view, options: { ...options } });
}

function pause() {
  settle();
  document.dispatchEvent(new Event("pause"));
}

export const undoable = () => [past.length > 0, future.length > 0];

// The drive before the last change, or after the one that was undone; null where there is none.
export function step([from, to]) {
  if (!from.length) return null;
  to.push(drive);
  drive = from.pop();
  settle();
  return JSON.parse(drive);
}
