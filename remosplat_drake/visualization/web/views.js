// Views of the scene. Each viewer's page has its own view: it stays where the
// mouse has moved it, or follows the object that it looks at.
const views = (() => {
  let places = null; // Positions of hand, target and base in W [m].
  let chosen = "free";
  let centre = null; // Point that the view looked at in the last picture.
  let looked = 0; // Time of the last search for a clear view [ms].
  // A disc hides a point if its centre is nearer to the line of sight than CLOSE,
  // and farther than END from the point [m].
  const CLOSE = 0.03;
  const END = 0.08;
  const TURN = Math.PI / 6; // Angle between two views that are compared [rad].
  const AGAIN = 1000; // Time between two searches for a clear view [ms].

  const mean = (a, b) => a.map((v, i) => 0.5 * (v + b[i]));
  const sum = (a, b) => a.map((v, i) => v + b[i]);
  const less = (a, b) => a.map((v, i) => v - b[i]);
  const turned = ([x, y, z]) => [x, z, -y]; // Three.js has y up.

  // Vector to a camera that sees hand and target. It is beside them, so that they
  // do not hide each other, and above them, so that objects on a table hide little.
  const both = () => {
    const [x, y] = less(places.target, places.hand);
    const far = Math.hypot(x, y);
    const [ahead, aside] = far > 0.05 ? [x / far, y / far] : [1, 0];
    const away = 0.9 + 0.9 * far;
    return [away * aside, -away * ahead, 0.7 * away];
  };

  const between = () =>
    places.target ? mean(places.hand, places.target) : places.hand;

  // Returns whether a disc of the map hides a point from the camera.
  const hides = (from, at) => {
    const { Vector3 } = MeshCat.THREE;
    let found = false;
    const test = (mesh) => {
      if (!mesh.isInstancedMesh || found) return;
      const inverse = mesh.matrixWorld.clone().invert();
      const eye = new Vector3(...turned(from)).applyMatrix4(inverse);
      const way = new Vector3(...turned(at)).applyMatrix4(inverse).sub(eye);
      const size = mesh.matrixWorld.getMaxScaleOnAxis();
      const [close, end] = [CLOSE / size, 1 - END / size / way.length()];
      const disc = new Vector3();
      const { array } = mesh.instanceMatrix;
      for (let i = 12; i < array.length && !found; i += 16) {
        disc.set(array[i], array[i + 1], array[i + 2]).sub(eye);
        const along = disc.dot(way) / way.lengthSq();
        if (along < 0 || along > end) continue;
        found = disc.addScaledVector(way, -along).length() < close;
      }
    };
    const splat = viewer.scene_tree.find(["remosplat", "splat", "surfels"]).object;
    splat.updateWorldMatrix(true, true); // No picture may have been drawn yet.
    splat.traverse(test);
    return found;
  };

  const hidden = (from) =>
    [places.hand, places.target ?? places.hand].filter((at) => hides(from, at));

  // Returns the vector to a camera that sees both hand and target. It tries cameras
  // around them, the side view first; if none sees both, it takes the best one.
  const clear = () => {
    const [x, y, z] = places.target ? both() : [-0.6, -0.6, 0.45];
    let best = null;
    for (const height of [1, 2]) {
      for (const turn of [0, 1, -1, 2, -2, 3, -3, 4, -4, 5, -5, 6]) {
        const [c, s] = [Math.cos(turn * TURN), Math.sin(turn * TURN)];
        const aside = [c * x - s * y, s * x + c * y, height * z];
        const lost = hidden(sum(between(), aside)).length;
        if (!best || lost < best.lost) best = { aside, lost };
        if (!best.lost) return best.aside;
      }
    }
    return best.aside;
  };

  // For each view, the point that it looks at, and the camera's position.
  const all = {
    hand: [() => places.hand, () => [-0.6, -0.4, 0.35]],
    target: [() => places.target ?? places.hand, () => [-0.6, -0.6, 0.45]],
    both: [between, () => (places.target ? both() : [-0.6, -0.6, 0.45])],
    clear: [between, clear],
    top: [() => mean(places.hand, places.base), () => [-0.01, 0, 3.5]],
    follow: [() => mean(places.hand, places.base), () => [-1.5, -1.7, 1.4]],
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
    // The mouse may have turned the view, so it is only translated.
    const now = all[chosen][0]();
    const step = less(now, centre);
    const { x, y, z } = viewer.camera.position;
    const from = sum([x, -z, y], step);
    if (chosen === "clear" && performance.now() - looked > AGAIN) {
      looked = performance.now();
      if (hidden(from).length) return choose(chosen);
    }
    if (Math.hypot(...step) < 1e-3) return;
    centre = now;
    look(now, from);
  };

  const choose = (name) => {
    chosen = name;
    centre = null;
    for (const button of document.querySelectorAll("#views button")) {
      button.setAttribute("aria-pressed", button.dataset.view === name);
    }
    if (name === "free") return;
    if (!window.viewer?.camera || !places) {
      // The page is still loading.
      setTimeout(() => chosen === name && choose(name), 200);
      return;
    }
    const [at, aside] = all[name];
    centre = at();
    look(centre, sum(centre, aside()));
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
