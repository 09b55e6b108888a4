// A saved page: shows its stored content, and plays the recording.
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
