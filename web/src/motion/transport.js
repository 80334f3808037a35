// Play, pause, scrub, speed; and the keys that do the same.
import {h, toggle} from "../dom.js";
import {format} from "../data/numbers.js";

const speeds = [1, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.005];

/** The speed at which a run takes about four seconds. */
function comfortable(duration) {
  return speeds.reduce((best, s) =>
    Math.abs(Math.log(duration / s / 4)) < Math.abs(Math.log(duration / best / 4)) ? s : best);
}

export function transport(clock) {
  const play = h("button", {type: "button", class: "play", id: "play"});
  const scrub = h("input", {type: "range", id: "scrub", min: 0, step: 1, "aria-label": "Time"});
  // The slider tells its time itself: an output would be read out all through the motion.
  const reading = h("output", {class: "reading", for: "scrub", "aria-live": "off"});
  const speed = h("select", {id: "speed", "aria-label": "Speed"},
    speeds.map((s) => h("option", {value: s}, s === 1 ? "real time" : `1 : ${Math.round(1 / s)}`)));
  const loop = toggle("Loop", clock.loop, (on) => (clock.loop = on), {id: "loop"});

  play.addEventListener("click", () => clock.toggle());
  scrub.addEventListener("input", () => {
    clock.pause();
    clock.seekSample(Number(scrub.value));
  });
  speed.addEventListener("change", () => (clock.speed = Number(speed.value)));

  let known = null;
  const show = () => {
    if (clock.time !== known) {
      if (!known || known[known.length - 1] !== clock.duration) {
        clock.speed = comfortable(clock.duration);
        speed.value = String(clock.speed);
      }
      known = clock.time;
      scrub.max = String(clock.time.length - 1);
    }
    const state = clock.playing ? "Pause" : "Play";
    if (play.getAttribute("aria-label") !== state) {
      play.setAttribute("aria-label", state);
      play.dataset.state = clock.playing ? "playing" : "paused";
      play.innerHTML = clock.playing
        ? '<svg viewBox="0 0 16 16" aria-hidden="true"><path d="M4 3h3v10H4zM9 3h3v10H9z"/></svg>'
        : '<svg viewBox="0 0 16 16" aria-hidden="true"><path d="M5 2.8v10.4L13 8z"/></svg>';
    }
    scrub.value = String(clock.sample);
    const text = `${clock.time[clock.sample].toFixed(decimals(clock.duration))} s`;
    scrub.setAttribute("aria-valuetext", text);
    scrub.style.setProperty("--done", `${(100 * clock.sample) / (clock.time.length - 1)}%`);
    reading.textContent = `${text} of ${format(clock.duration)} s`;
  };
  clock.onChange(show);
  show();
  return h("div", {class: "transport", role: "group", "aria-label": "Animation"}, play, scrub, reading, speed, loop);
}

function decimals(duration) {
  return Math.max(0, Math.min(6, 4 - Math.ceil(Math.log10(duration))));
}

/** Space plays and pauses, arrows step, Home and End jump: wherever a key has no meaning of its own. */
export function listenToKeys(clock, zoom) {
  // A button that was clicked with the pointer has done its work: the next space is not for it.
  document.addEventListener("click", (event) => {
    if (event.detail > 0) event.target.closest?.("button, summary, a")?.blur();
  });
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const slider = event.key === " " && event.target.matches?.('input[type="range"]');
    const own = !slider && event.target.closest?.("input, select, textarea, [contenteditable]");
    const pressable = event.target.closest?.("button, a, summary");
    const far = event.shiftKey ? 10 : 1;
    const actions = {
      " ": () => clock.toggle(),
      ArrowRight: () => clock.step(far),
      ArrowLeft: () => clock.step(-far),
      Home: () => clock.step(-Infinity),
      End: () => clock.step(Infinity),
      "+": () => zoom.by(0.5),
      "=": () => zoom.by(0.5),
      "-": () => zoom.by(2),
      0: () => zoom.reset(),
    };
    const action = actions[event.key];
    if (!action || own || (pressable && event.key === " ")) return;
    event.preventDefault();
    action();
  });
}

