// The bar and the panel, for served and saved pages: `panel.show` draws each
// item that Python sends.
const panel = (() => {
  const find = (id) => document.getElementById(id);
  const make = (tag, text = "", parts = []) => {
    const element = document.createElement(tag);
    element.textContent = text;
    element.append(...parts);
    return element;
  };
  const fill = (id, ...parts) => find(id).replaceChildren(...parts);

  const bar = ({ phase, title, text, over, buttons }) => {
    find("bar").className = phase;
    find("bar").querySelector("b").textContent = title;
    find("bar").querySelector("span").textContent = text;
    const { dataset } = document.documentElement;
    // The style sheet hides all other buttons.
    dataset.buttons = buttons.join(" ");
    dataset.over = over;
  };

  const badge = ({ grade, title, text }) => {
    find("badge").className = grade;
    fill("badge", make("b", title), " " + text);
  };

  const notes = (lines) =>
    fill(
      "notes",
      ...lines.map(([topic, text, trouble]) => {
        const title = topic[0].toUpperCase() + topic.slice(1) + ":";
        const line = make("p", "", [make("b", title), " " + text + " "]);
        if (trouble) line.append(make("em", trouble));
        line.dataset.topic = topic;
        return line;
      }),
    );

  // Python makes the plots, so their HTML needs no escaping.
  const plot = (name, svg) => {
    let place = find("plot-" + name);
    if (!place) {
      place = make("div");
      place.id = "plot-" + name;
      find("plots").append(place);
    }
    place.innerHTML = svg;
  };

  const legend = (entries) =>
    fill(
      "legend",
      make("h2", "Legend"),
      make(
        "ul",
        "",
        entries.map(([color, text]) => {
          const sample = make("i");
          sample.style.background = color;
          return make("li", "", [sample, text]);
        }),
      ),
    );

  // Present state of each toggle; each viewer's page has its own states.
  const states = new Map();
  let toggles = [];

  const apply = ({ label, states: all }) => {
    const shown = all[states.get(label)][1];
    for (const path of new Set(all.flatMap(([, paths]) => paths))) {
      const visible = shown.includes(path);
      window.viewer?.set_property(path.split("/").slice(1), "visible", visible);
    }
    window.viewer?.set_dirty();
  };

  const step = (toggle) => {
    const next = (states.get(toggle.label) + 1) % toggle.states.length;
    states.set(toggle.label, next);
    apply(toggle);
    scene(toggles);
  };

  const scene = (entries) => {
    toggles = entries;
    const buttons = entries.map((toggle) => {
      const { label, key, states: all, initial } = toggle;
      if (!states.has(label)) states.set(label, initial);
      const [name, paths] = all[states.get(label)];
      const button = make("button", label, [make("output", name)]);
      button.append(make("kbd", key));
      button.setAttribute("aria-pressed", paths.length > 0);
      button.addEventListener("click", () => step(toggle));
      return button;
    });
    if (buttons.length) fill("scene", make("h2", "Scene"), ...buttons);
  };

  const account = ({ facts, plots, moments }) => {
    const rows = facts.map((row) => make("tr", "", row.map((t) => make("td", t))));
    const over = make("div");
    over.innerHTML = plots.join("");
    const events = make(
      "div",
      "",
      moments.map(([time, text]) => {
        const at = make("time", time.toFixed(1) + " s");
        const event = make("button", "", [at, make("span", text)]);
        event.dataset.time = time;
        return event;
      }),
    );
    events.id = "events";
    fill(
      "account",
      ...(rows.length ? [make("h2", "Result"), make("table", "", rows)] : []),
      make("h2", "Over time"),
      over,
      make("h2", "Events"),
      events,
    );
    fill("plots");
  };

  const show = (topic, ...value) => {
    const drawn = { bar, badge, notes, plot, legend, scene, account };
    ({ ...drawn, task: task.show })[topic]?.(...value);
  };

  addEventListener("keydown", (press) => {
    if (press.target.matches?.("input[type=text]")) return;
    toggles.filter(({ key }) => key === press.key).forEach(step);
  });

  return { show, make, fill, apply: () => toggles.forEach(apply) };
})();
