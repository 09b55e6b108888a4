// Measures the age of a page's content. The page requests the newest state, and
// requests it again when it has drawn the answer.
const age = (() => {
  const OLD = 0.5; // The page displays ages greater than this [s].
  const LOOK = 0.1; // Time between two checks of the age [s].
  const LOST = 20; // Checks without an answer until the connection counts as lost.
  let asked = performance.now();
  let heard = asked;
  let behind = 0; // Age of the latest answer's content on arrival [s].
  let drawnIn = 0; // Time that the last picture took to draw [s].
  // Number of checks since an unanswered request. Time is not used, since a
  // browser that is busy drawing does not check.
  let silence = 0;
  let waits = true;

  const ask = () => {
    asked = performance.now();
    waits = true;
  };

  // Receives an answer, and computes an upper bound of its age. `waited` is the
  // time for which the server waited for a change, and `age` the content's age
  // when the answer was sent [s].
  const take = ({ waited, age: old }) => {
    heard = performance.now();
    silence = 0;
    waits = false;
    behind = Math.max(0, (heard - asked) / 1000 - waited) + old;
  };

  // Waits until the browser has drawn; a hidden page does not draw.
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

  // Calls a function periodically; returns a function that ends the calls.
  const watch = (look) => {
    const timer = setInterval(() => {
      if (waits) silence += 1;
      look();
    }, 1000 * LOOK);
    return () => clearInterval(timer);
  };

  return { ask, take, drawn, lose, isLost, now, text, watch };
})();
