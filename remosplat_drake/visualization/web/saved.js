// A saved page: it shows what was told when it was written, and plays it.
addEventListener("DOMContentLoaded", () => {
  for (const [topic, value] of Object.entries(told)) panel.show(topic, value);
  panel.apply();
  const { account } = told;
  if (viewer.animator.duration) {
    player.open(account ?? { begin: 0, idle: [] }, { playing: true });
  }
  document.querySelector(".dg.main")?.remove();
  dispatchEvent(new Event("resize"));
});
