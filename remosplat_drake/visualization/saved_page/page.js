// The player of a saved page: one time line for the scene, the plots and the
// list of events. `account` is what Python wrote: see `account.py`.
(() => {
  const account = JSON.parse(document.getElementById("account").textContent);
  const find = (selector) => [...document.querySelectorAll(selector)];
  const [slider] = find("#time");
  const [button] = find("#play");
  const [clock] = find("#clock");
  const span = viewer.animator.duration;
  let now = 0;
  let playing = false;

  const show = (time) => {
    now = Math.max(0, Math.min(span, time));
    if (span) viewer.animator.seek(now);
    slider.value = now;
    clock.textContent = now.toFixed(1) + " s";
    for (const line of find(".cursor")) {
      const { left, right, end } = line.dataset;
      const x = +left + ((right - left) * Math.min(now, end)) / end;
      line.setAttribute("x1", x);
      line.setAttribute("x2", x);
    }
    const past = find("#events button").filter((e) => e.dataset.time <= now);
    for (const event of find("#events button")) {
      event.classList.toggle("now", event === past[past.length - 1]);
    }
  };

  const play = (on) => {
    playing = on;
    button.textContent = on ? "Pause" : "Play";
    if (on && now >= span) show(account.begin);
  };

  let before = performance.now();
  const step = (time) => {
    // A frame may bear a time from before the script began.
    const passed = Math.max(0, Math.min(0.25, (time - before) / 1000));
    before = time;
    if (playing) {
      const idle = account.idle.find(([a, b]) => a <= now && now < b);
      show(idle ? idle[1] : now + passed);
      if (now >= span) play(false);
    }
    requestAnimationFrame(step);
  };

  const toggle = (item) => {
    const { states, element } = item;
    for (const path of new Set(states.flat())) {
      const shown = states[item.state].includes(path);
      viewer.set_property(path.split("/").slice(1), "visible", shown);
    }
    viewer.set_dirty();
    element.setAttribute("aria-pressed", states[item.state].length > 0);
  };

  slider.max = span;
  slider.addEventListener("input", () => (play(false), show(+slider.value)));
  button.addEventListener("click", () => play(!playing));
  for (const event of find("#events button")) {
    event.addEventListener("click", () => {
      play(false);
      show(+event.dataset.time);
    });
  }
  for (const [i, item] of account.toggles.entries()) {
    item.element = find("#toggles button")[i];
    const next = () => {
      item.state = (item.state + 1) % item.states.length;
      toggle(item);
    };
    item.element.addEventListener("click", next);
    addEventListener("keydown", (press) => press.key === item.key && next());
    toggle(item);
  }
  addEventListener("keydown", (press) => {
    if (press.key !== " ") return;
    press.preventDefault();
    play(!playing);
  });
  if (span) {
    viewer.animator.pause();
    show(account.begin);
    play(true);
  } else {
    find("#player")[0].hidden = true;
  }
  requestAnimationFrame(step);
  dispatchEvent(new Event("resize"));
})();
