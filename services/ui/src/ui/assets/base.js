// What the other scripts share: words in the page's language, parts of the page, and pulling over a socket.
window.atom = (() => {
  "use strict";
  const RETRY_MS = 1000;
  const found = document.getElementById("atom-texts");
  const words = found ? JSON.parse(found.textContent) : {};

  function t(text, values = {}) {
    return (words[text] || text).replace(/\{(\w+)\}/g, (whole, name) => (name in values ? String(values[name]) : whole));
  }

  const box = () => document.querySelector("[data-atom-say] input, input[data-atom-say]");
  const said = () => (box() ? box().value : "");

  const part = (name) => document.querySelector(`[data-atom="${name}"]`);

  function say(name, text, tone = "") {
    const note = part(name);
    if (!note) return;
    if (note.textContent !== text) note.textContent = text;
    note.dataset.tone = tone;
  }

  // Asks for the next message when the last one is drawn; in a hidden tab it asks for nothing. `draw` may be async.
  function pull(path, draw, trouble) {
    let socket = null;
    let waiting = false;
    let again = 0;

    function ask() {
      if (document.hidden) { waiting = true; return; }
      waiting = false;
      if (socket && socket.readyState === WebSocket.OPEN) socket.send("next");
    }

    function open() {
      window.clearTimeout(again);
      socket = new WebSocket(`${location.protocol === "https:" ? "wss" : "ws"}://${location.host}${path}`);
      socket.binaryType = "arraybuffer";
      socket.onopen = ask;
      socket.onmessage = async (message) => {
        try {
          await draw(message.data);
        } catch (error) {
          trouble(String(error.message || error));
        }
        ask();
      };
      socket.onclose = () => {
        trouble(t("the page's service does not answer"));
        again = window.setTimeout(open, RETRY_MS);
      };
    }

    document.addEventListener("visibilitychange", () => { if (!document.hidden && waiting) ask(); });
    open();
  }

  return { t, box, said, part, say, pull };
})();
