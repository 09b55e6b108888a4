// The player: one time line for the scene, the plots and the list of events.
const player = (() => {
  const find = (selector) => [...document.querySelectorAll(selector)];
  const [slider] = find("#time");
  const [button] = find("#play");
  const [clock] = find("#clock");
  let account = { begin: 0, idle: [] };
  let span = 0;
  let now = 0;
  let playing = false;

  const shown = (time) => time.toFixed(1) + " s";

  const show = (time) => {
    now = Math.max(0, Math.min(span, time));
    // A time that is displayed like the end, after rounding, counts as the end.
    if (shown(now) === shown(span)) now = span;
    if (span) viewer.animator.seek(now);
    slider.value = now;
    clock.textContent = shown(now);
    for (const line of find(".cursor")) {
      const { left, right, end } = line.dataset;
      const x = +left + ((right - left) * Math.min(now, end)) / end;
      line.setAttribute("x1", x);
      line.setAttribute("x2", x);
    }
    // A recording ends with its last frame, up to one frame before the run's end.
    const past = find("#events button").filter(
      (e) => e.dataset.time <= now + (now < span ? 0 : 0.1),
    );
    const latest = past[past.length - 1];
    for (const event of find("#events button")) {
      event.classList.toggle("now", event === latest);
    }
    // The outcome is shown at the end.
    const { state } = account;
    if (!state || state.phase === "replayed") return;
    const then = latest?.querySelector("span").textContent ?? "";
    const title = "Replay";
    const bar = { ...state, phase: "replayed", title, text: then };
    panel.show("bar", now < span ? bar : state);
  };

  const play = (on) => {
    playing = on;
    button.textContent = on ? "Pause" : "Play";
    if (on && now >= span) show(account.begin);
  };

  let before = performance.now();
  const step = (time) => {
    // The time stamp of a frame may be earlier than the start of the script.
    const passed = Math.max(0, Math.min(0.25, (time - before) / 1000));
    before = time;
    if (playing) {
      const idle = account.idle.find(([a, b]) => a <= now && now < b);
      show(idle ? idle[1] : now + passed * account.rate);
      if (now >= span) play(false);
    }
    requestAnimationFrame(step);
  };

  slider.addEventListener("input", () => (play(false), show(+slider.value)));
  button.addEventListener("click", () => play(!playing));
  document.addEventListener("click", (click) => {
    const event = click.target.closest("#events button");
    if (!event || !span) return;
    play(false);
    show(+event.dataset.time);
  });
  addEventListener("keydown", (press) => {
    if (press.key !== " " || !span) return;
    press.preventDefault();
    play(!playing);
  });
  requestAnimationFrame(step);

  // Takes over a recording, which begins with the first motion.
  const open = (told, { playing: on, at }) => {
    account = { rate: 1, ...told };
    span = viewer.animator.duration;
    slider.max = span;
    find("#player")[0].hidden = !span;
    if (!span) return;
    viewer.animator.pause();
    show(at ?? account.begin);
    play(on);
    dispatchEvent(new Event("resize"));
  };

  return { open };
})();
