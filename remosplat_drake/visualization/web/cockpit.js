// Additions to viser's page for the cockpit: the age of its content, the
// operator's gamepad, and a panel that folds on a phone. Messages to the server
// are written into a hidden text field of viser.
(() => {
  window.remosplat?.end(); // After a lost connection this script runs again.
  const PERIOD = 0.05; // Time between two messages [s].
  let asked = 0;
  let isDrawn = true;

  const label = document.getElementById("age") ?? document.createElement("div");
  label.id = "age";
  document.body.append(label);

  // Events of the field are not used: viser sends one change in 50 ms, and would
  // then omit changes that the person makes.
  const say = (message) => {
    const send = window.__viserMutable?.sendMessage;
    if (!send) return false;
    const updates = { value: JSON.stringify(message) };
    send({ type: "GuiUpdateMessage", uuid: channel, updates });
    return true;
  };

  // The time makes each message new, even if the gamepad's state is unchanged.
  const gamepad = () => {
    const pads = document.hidden ? [] : (navigator.getGamepads?.() ?? []);
    const pad = [...pads].find((one) => one?.connected);
    if (!pad) return null;
    const buttons = pad.buttons.map(({ value }) => value);
    return { at: performance.now(), axes: [...pad.axes], buttons };
  };

  const step = () => {
    const pad = gamepad();
    if (!(isDrawn || pad) || !say({ asked: asked + isDrawn, gamepad: pad })) return;
    if (!isDrawn) return;
    isDrawn = false;
    asked += 1;
    age.ask();
  };

  const answer = async (number, old) => {
    if (number !== asked) return;
    age.take({ waited: 0, age: old });
    await age.drawn();
    isDrawn = true;
  };

  // viser's own folding would hide STOP.
  const fold = (click) => {
    const handle = '[style*="max-height: 60%"] [style*="3.5em"][style*="font-weight: 400"]';
    if (!click.target.closest(handle) || click.target.closest("button")) return;
    click.stopPropagation();
    document.documentElement.toggleAttribute("data-folded");
  };

  const timer = setInterval(step, 1000 * PERIOD);
  const endWatch = age.watch(() => {
    const text = age.text();
    if (label.textContent !== text) label.textContent = text;
  });
  addEventListener("click", fold, true);
  const end = () => {
    clearInterval(timer);
    endWatch();
    removeEventListener("click", fold, true);
  };
  window.remosplat = { answer, end };
})();
