// Where people look from. Each onlooker has a view of his own: it stays as the
// mouse has put it, or goes along with what it looks at.
const views = (() => {
  let places = null; // Positions of hand, target and base in W [m].
  let chosen = "free";
  let centre = null; // What the view looked at in the last picture.

  const mean = (a, b) => a.map((v, i) => 0.5 * (v + b[i]));
  const sum = (a, b) => a.map((v, i) => v + b[i]);
  const less = (a, b) => a.map((v, i) => v - b[i]);
  const turned = ([x, y, z]) => [x, z, -y]; // Three.js has y up.

  // From the side of the line between hand and target neither hides the other,
  // and from above things on a table hide little.
  const both = () => {
    const [x, y] = less(places.target, places.hand);
    const far = Math.hypot(x, y);
    const [ahead, aside] = far > 0.05 ? [x / far, y / far] : [1, 0];
    const away = 0.9 + 0.9 * far;
    return [away * aside, -away * ahead, 0.7 * away];
  };

  // What each view looks at, and from where beside it.
  const all = {
    hand: () => [places.hand, [-0.6, -0.4, 0.35]],
    target: () => [places.target ?? places.hand, [-0.6, -0.6, 0.45]],
    both: () =>
      places.target
        ? [mean(places.hand, places.target), both()]
        : [places.hand, [-0.6, -0.6, 0.45]],
    top: () => [mean(places.hand, places.base), [-0.01, 0, 3.5]],
    follow: () => [mean(places.hand, places.base), [-1.5, -1.7, 1.4]],
  };

  const look = (at, from) => {
    viewer.set_property(
      ["Cameras", "default", "rotated", "<object>"],
      "position",
      turned(from),
    );
    viewer.set_camera_target(turned(at));
    viewer.set_dirty();
  };

  const show = (told) => {
    places = told;
    if (!window.viewer?.camera || !centre || chosen === "free") return;
    // The mouse may have turned the view: it only goes along.
    const [now] = all[chosen]();
    const step = less(now, centre);
    if (Math.hypot(...step) < 1e-3) return;
    centre = now;
    const { x, y, z } = viewer.camera.position;
    look(now, sum([x, -z, y], step));
  };

  const choose = (name) => {
    chosen = name;
    centre = null;
    for (const button of document.querySelectorAll("#views button")) {
      button.setAttribute("aria-pressed", button.dataset.view === name);
    }
    if (name === "free") return;
    if (!window.viewer?.camera || !places) {
      // It is loading.
      setTimeout(() => chosen === name && choose(name), 200);
      return;
    }
    const [at, aside] = all[name]();
    centre = at;
    look(at, sum(at, aside));
  };

  for (const name of ["free", ...Object.keys(all)]) {
    const button = document.createElement("button");
    button.textContent = button.dataset.view = name;
    button.addEventListener("click", () => choose(name));
    document.getElementById("views").append(button);
  }
  choose("free");

  return { show };
})();
