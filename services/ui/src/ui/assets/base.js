// What the other scripts share, written into the page itself: words in its language, its parts, its addresses, sockets.
window.atom = (() => {
  "use strict";
  const RETRY_MS = 1000;
  const found = document.getElementById("atom-texts");
  const words = found ? JSON.parse(found.textContent) : {};
  const missing = new Set();

  function t(text, values = {}) {
    return (words[text] || text).replace(/\{(\w+)\}/g, (whole, name) => (name in values ? String(values[name]) : whole));
  }

  // The one way to an address: from where the page lies, which may be below a proxy's prefix.
  const url = (path) => new URL(path, document.baseURI);

  function socketUrl(path) {
    const address = url(path);
    address.protocol = address.protocol === "https:" ? "wss:" : "ws:";
    return address;
  }

  // Every question has an end. STOP asks with this one: whatever is answered, it stays and tells.
  const fetchWithin = (path, limit_ms, options = {}) =>
    fetch(url(path), { cache: "no-store", ...options, signal: AbortSignal.timeout(limit_ms) });

  // A log-in that has ended leads to the form, which has a STOP too; not while a stop is under way.
  async function ask(path, limit_ms, options = {}) {
    const answer = await fetchWithin(path, limit_ms, options);
    if (answer.status === 401 && !document.documentElement.dataset.stopping) window.location.assign(url("login"));
    return answer;
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
  // `wanted` says what to ask for.
  function pull(path, draw, trouble, wanted = () => "next") {
    let socket = null;
    let waiting = false;
    let again = 0;

    function next() {
      if (document.hidden) { waiting = true; return; }
      waiting = false;
      if (socket && socket.readyState === WebSocket.OPEN) socket.send(wanted());
    }

    function open() {
      window.clearTimeout(again);
      socket = new WebSocket(socketUrl(path));
      socket.binaryType = "arraybuffer";
      socket.onopen = next;
      socket.onmessage = async (message) => {
        try {
          await draw(message.data);
        } catch (error) {
          trouble(String(error.message || error));
        }
        next();
      };
      socket.onclose = () => {
        trouble(t("the server does not answer"));
        ask("assets/icon.svg", RETRY_MS).catch(() => {});  // a refused socket does not tell a script why; this does
        again = window.setTimeout(open, RETRY_MS);
      };
    }

    document.addEventListener("visibilitychange", () => { if (!document.hidden && waiting) next(); });
    open();
  }

  // A control is shown once the script that moves it stands (assets/stop.css); what did not load is named.
  const ready = (name) => document.documentElement.classList.add(`${name}-ready`);

  function sayMissing() {
    if (missing.size === 0) return;
    say("page-missing", t("Parts of this page did not load: {parts}. Reload it.", { parts: [...missing].join(", ") }));
  }

  window.addEventListener("error", (event) => {
    const from = event.target instanceof Element ? event.target.src || event.target.href || "" : event.filename || "";
    const isFile = event.target instanceof HTMLScriptElement || event.target instanceof HTMLLinkElement;
    if (!isFile && !from.includes("assets/")) return;
    missing.add(from.split("?")[0].split("/").pop() || "script");
    sayMissing();
  }, true);
  document.addEventListener("DOMContentLoaded", sayMissing);

  return { t, url, socketUrl, fetchWithin, ask, box, said, part, say, pull, ready };
})();
