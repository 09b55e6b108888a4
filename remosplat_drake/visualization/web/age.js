// The age of a page's picture. The page asks for the newest state, and asks
// again when it has drawn the answer.
const age = (() => {
  const OLD = 0.5; // Age from which on it is said [s].
  const LOOK = 0.1; // Time between two looks at the age [s].
  const LOST = 20; // Looks without an answer after which none is expected.
  let asked = performance.now();
  let heard = asked;
  let behind = 0; // Age of the answer when it came [s].
  let drawnIn = 0; // Time that the last picture took [s].
  // Since a question, in looks: a browser that is busy drawing loses nothing.
  let silence = 0;
  let waits = true;

  const ask = () => {
    asked = performance.now();
    waits = true;
  };

  // At most so long ago; the server knows how long it has waited.
  const take = ({ waited, age: old }) => {
    heard = performance.now();
    silence = 0;
    waits = false;
    behind = Math.max(0, (heard - asked) / 1000 - waited) + old;
  };

  // Until the browser has drawn; a hidden page draws nothing.
  const drawn = () =>
    new Promise((done) => {
      const begun = performance.now();
      const end = () => {
        drawnIn = document.hidden ? 0 : (performance.now() - begun) / 1000;
        done();
      };
      const frame = requestAnimationFrame(() => setTimeout(end));
      if (document.hidden) setTimeout(() => (cancelAnimationFrame(frame), end()), 50);
    });

  const lose = () => (silence = Math.max(silence, LOST));
  const isLost = () => silence > LOST;

  const now = () => (performance.now() - heard) / 1000 + behind;

  const text = () => {
    const old = Math.max(now(), drawnIn);
    return old > OLD ? `${old.toFixed(1)} s old` : "";
  };

  // Calls a function again and again; returns what ends that.
  const watch = (look) => {
    const timer = setInterval(() => {
      if (waits) silence += 1;
      look();
    }, 1000 * LOOK);
    return () => clearInterval(timer);
  };

  return { ask, take, drawn, lose, isLost, now, text, watch };
})();
