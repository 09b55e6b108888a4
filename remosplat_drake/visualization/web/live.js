// The page while it is served. Shapes come from Meshcat, all other content from
// our server. The page requests the values that have changed since the last
// picture; when it has drawn them, it sends the next request. It uses a
// websocket, since a browser's few other connections are busy loading meshes.
(() => {
  const { socket, session } = remosplat;
  const moved = new Set(); // Paths and properties that only we change.
  let version = 0;
  let bar = null;
  let hasMeshcat = null;
  let account = null;

  const path = (name) => name.split("/").slice(1);

  const change = ([kind, name, ...rest]) => {
    if (kind === "pose") {
      const bytes = Uint8Array.from(atob(rest[0]), (c) => c.charCodeAt(0));
      viewer.set_transform(path(name), new Float64Array(bytes.buffer));
      moved.add(name);
    } else if (kind === "property") {
      viewer.set_property(path(name), ...rest);
      moved.add(name + " " + rest[0]);
    } else {
      if (kind === "bar") bar = name;
      if (kind === "account") account = name;
      if (kind === "places") {
        document.documentElement.dataset.views = true;
        return views.show(name);
      }
      panel.show(kind, name, ...rest);
    }
  };

  const isMotion = ([kind]) => kind === "pose" || kind === "property";
  let early = []; // Motions that arrive before Meshcat is loaded.

  const tellAge = () => {
    const over = bar?.over;
    const lost = age.isLost();
    const deaf = lost || hasMeshcat === false;
    document.documentElement.dataset.deaf = deaf;
    const text = over
      ? lost ? "the program has ended" : ""
      : lost
        ? `no connection: as of ${age.now().toFixed(0)} s ago`
        : deaf
          ? "no connection to the second port: buttons and motion do not work"
          : age.text();
    const place = document.getElementById("age");
    if (place.textContent !== text) place.textContent = text;
  };

  const take = (answer) => {
    if (answer.session !== session) return location.reload();
    age.take(answer);
    version = answer.version;
    const motion = early.concat(answer.changes.filter(isMotion));
    answer.changes.filter((item) => !isMotion(item)).forEach(change);
    early = window.viewer ? [] : motion;
    if (window.viewer && motion.length) {
      motion.forEach(change);
      viewer.set_dirty();
    }
    tellAge();
  };

  const listen = () => {
    const news = new WebSocket(`ws://${location.host}/newest`);
    const ask = () => {
      age.ask();
      if (news.readyState === WebSocket.OPEN) news.send(version);
    };
    news.onopen = ask;
    news.onmessage = async (message) => {
      take(JSON.parse(message.data));
      await age.drawn();
      ask();
    };
    news.onclose = () => {
      age.lose();
      setTimeout(listen, 500);
    };
  };

  // Draws the scene. After a picture that takes long, it waits before the next
  // one, so that the browser can handle other events.
  const draw = () => {
    let after = 0;
    viewer.animate = () => {
      viewer.animator.update();
      const begun = performance.now();
      if (!viewer.needs_render || begun < after) return;
      viewer.render();
      const end = performance.now();
      after = end + Math.min(100, 0.3 * (end - begun));
    };
  };

  const connect = () => {
    const address = `ws://${location.hostname}:${socket}`;
    // Meshcat's functions send by `viewer.connection` and by `connection`.
    const ours = (window.connection = viewer.connection = new WebSocket(address));
    ours.binaryType = "arraybuffer";
    ours.onopen = () => {
      if (hasMeshcat === false) return location.reload();
      hasMeshcat = true;
      viewer.render_callback();
    };
    ours.onclose = () => {
      hasMeshcat = false;
      tellAge();
      setTimeout(connect, 1000);
    };
    ours.onmessage = (message) => {
      const command = viewer.decode(message);
      const { type, path: name, property } = command;
      const ownedBy = type === "set_transform" ? name : name + " " + property;
      if (moved.has(ownedBy) && !bar?.over) return;
      viewer.handle_command(command);
      if (type === "set_animation") replay();
    };
  };

  const replay = () => {
    // The recording comes from Meshcat, and its summary from our server.
    if (!account || !viewer.animator.duration) return setTimeout(replay, 100);
    const again = bar?.phase === "replayed";
    const at = again ? account.begin : viewer.animator.duration;
    player.open(account, { playing: again, at });
  };

  // While a gamepad's dead-man switch is held, the page clicks the hidden button
  // that reports it.
  setInterval(() => {
    const switched = document.querySelector(".remosplat-pulse");
    if (!switched || document.hidden) return;
    const pad = [...(navigator.getGamepads?.() || [])].find((p) => p?.connected);
    if (!(pad?.buttons[switched.dataset.button]?.value > 0.5)) return;
    switched.closest("li").click();
  }, 50);

  listen();
  age.watch(tellAge);
  addEventListener("DOMContentLoaded", () => {
    document.getElementById("controls").append(document.querySelector(".dg.main"));
    draw();
    connect();
    dispatchEvent(new Event("resize"));
  });
})();
