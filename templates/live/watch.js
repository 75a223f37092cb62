"use strict";
// Asks how the study stands, shows it in the bar, and loads the page anew when there is another one, at the same place.
(() => {
  const bar = document.getElementById("live");
  const words = bar.querySelector("p");
  const messages = bar.querySelector("pre");
  const folded = () => [...document.querySelectorAll("main details")];
  const key = "bmv " + location.pathname;
  const kept = sessionStorage.getItem(key);
  if (kept) {
    sessionStorage.removeItem(key);
    const { open, top } = JSON.parse(kept);
    const all = folded();
    open.forEach((place) => { if (all[place]) all[place].open = true; });
    scrollTo({ top, behavior: "instant" });
  }
  const said = { ready: "up to date", running: "running", wrong: "the files cannot be used as they are; shown is the last good report" };
  const show = (element, text) => { if (element.textContent !== text) element.textContent = text; };
  const look = async () => {
    try {
      const answer = await fetch("/status", { cache: "no-store" });
      if (!answer.ok) throw new Error(String(answer.status));
      const now = await answer.json();
      if (String(now.version) !== bar.dataset.version) {
        const open = folded().flatMap((part, place) => (part.open ? [place] : []));
        sessionStorage.setItem(key, JSON.stringify({ open, top: scrollY }));
        location.reload();
        return;
      }
      bar.dataset.state = now.state;
      show(words, [said[now.state], ...now.lines].join("\n"));
      show(messages, now.messages);
      messages.hidden = !now.messages;
    } catch {
      bar.dataset.state = "gone";
      show(words, "it has ended, or cannot be reached");
    }
    setTimeout(look, 500);
  };
  look();
})();
