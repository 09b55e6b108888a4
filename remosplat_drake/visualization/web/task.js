// A task: its jobs, the steps of the present one, and its objects. A click on an
// object, in the list or in the scene, marks it in both. An operator takes the
// marked object, or puts the carried one on it, by hidden buttons of Meshcat.
const task = (() => {
  // Colours with their opacity: as Python draws an object, and marked.
  const PLAIN = ["#8c59bf", 0.6];
  const MARKED = ["#ffb319", 0.9];
  const STILL = 4; // A press that moves the pointer further is no click [px].
  let told = null;
  let chosen = "";

  const path = (name) => [...told.root.split("/").slice(1), name];

  const paint = (name, [color, opacity]) => {
    if (!name || !window.viewer) return;
    const { r, g, b } = new MeshCat.THREE.Color(color);
    viewer.set_property(path(name), "color", [r, g, b, opacity]);
    viewer.set_dirty();
  };

  const choose = (name) => {
    paint(chosen, PLAIN);
    chosen = name === chosen ? "" : name;
    paint(chosen, MARKED);
    show(told);
  };

  const line = ({ text, state, is_step }) => {
    const item = panel.make("li", text);
    item.dataset.state = state;
    if (is_step) item.dataset.step = true;
    if (state === "present") item.setAttribute("aria-current", "step");
    return item;
  };

  const thing = ({ name, text, may_be_touched }) => {
    const button = panel.make("button", name, [panel.make("output", text)]);
    button.dataset.object = name;
    button.dataset.touched = may_be_touched;
    button.setAttribute("aria-pressed", name === chosen);
    button.addEventListener("click", () => choose(name));
    return button;
  };

  // A button that clicks a hidden one; none for people who only watch.
  const act = (text, action, index = 0) => {
    const hidden = document.querySelector(
      `.remosplat-${action}[data-index="${index}"]`,
    );
    if (!hidden) return [];
    const button = panel.make("button", text);
    button.dataset.action = action;
    button.addEventListener("click", () => hidden.closest("li").click());
    return [button];
  };

  const request = ({ name, is_carried }, index, objects) => {
    if (name !== chosen || is_carried) return [];
    const held = objects.find((other) => other.is_carried);
    if (held) return act(`Put the ${held.name} there`, "put", index);
    return act("Take it", "take", index);
  };

  const show = (outline) => {
    told = outline;
    const { lines, objects, failures } = outline;
    const runs = lines.some(({ state }) => state === "present");
    const parts = [];
    if (lines.length || failures.length) {
      const list = panel.make("ol", "", lines.map(line));
      parts.push(panel.make("h2", "Task"), list);
    }
    failures.forEach((text) => parts.push(panel.make("em", text)));
    if (runs) parts.push(...act("Give up", "give-up"));
    if (objects.length) {
      parts.push(panel.make("h2", "Objects"));
      objects.forEach((each, i) => {
        parts.push(thing(each), ...(runs ? [] : request(each, i, objects)));
      });
    }
    panel.fill("task", ...parts);
  };

  // Name of the object at a place of the window; empty if there is none.
  const at = (x, y) => {
    const { Raycaster, Vector2 } = MeshCat.THREE;
    const { left, top, width, height } =
      viewer.renderer.domElement.getBoundingClientRect();
    const place = new Vector2(
      (2 * (x - left)) / width - 1,
      1 - (2 * (y - top)) / height,
    );
    const ray = new Raycaster();
    ray.setFromCamera(place, viewer.camera);
    const hits = told.objects.flatMap(({ name }) =>
      ray
        .intersectObject(viewer.scene_tree.find(path(name)).object, true)
        .map(({ distance }) => ({ name, distance })),
    );
    hits.sort((a, b) => a.distance - b.distance);
    return hits[0]?.name ?? "";
  };

  let pressed = null;
  addEventListener("pointerdown", (press) => (pressed = press));
  addEventListener("pointerup", (release) => {
    if (!told || !window.viewer || !pressed) return;
    // The controls of the view capture the pointer, so the target of the release
    // is always the canvas; the target of the press is tested instead.
    if (pressed.target !== viewer.renderer.domElement) return;
    const [x, y] = [release.clientX, release.clientY];
    if (Math.hypot(x - pressed.clientX, y - pressed.clientY) > STILL) return;
    const name = at(x, y);
    if (name) choose(name);
  });

  return { show };
})();
