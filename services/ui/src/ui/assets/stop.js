// STOP works in the browser itself, also while the page's own connection is down; and says when it cannot work.
(() => {
  "use strict";
  const { t, part, say, fetchWithin } = window.atom;
  const STOP_LIMIT_MS = 8000;
  const SHOWN_MS = 8000;
  const LOOK_MS = 100;
  const ASK_MS = 400;  // between two questions whether a stop would reach the robot
  const SILENT_MS = 1300;  // without a good answer STOP counts as dead: shown within 2 s, with room for a slow look
  const place = part("stop-place");
  const { remedy } = place.dataset;
  const who = { bridge: 0, page: 0 };  // when the robot's side, and when the page's service, answered last
  let asked = 0;
  let shownOf = 0;
  let why = "";
  let presses = 0;
  let fading = 0;

  // ---- would it work? --------------------------------------------------------------------------------------------

  async function look() {
    const number = ++asked;
    try {
      const answer = await fetchWithin("stop", SILENT_MS);
      const told = await answer.json();
      const ours = answer.headers.get("content-type") || "";
      if (answer.ok && (typeof told.latched === "boolean" || told.latched === null)) {
        who.bridge = who.page = performance.now();
        if (told.latched !== null && number > shownOf) show(told.latched, number);
      } else if (ours.includes("application/problem+json")) {
        who.page = performance.now();
        why = told.detail || told.title;
      } else {
        why = t("another program answers at this address (HTTP {status})", { status: answer.status });
      }
    } catch (error) {
      why = error instanceof SyntaxError ? t("another program answers at this address") : t("the server does not answer");
    }
  }

  function show(stopped, number) {
    shownOf = number;
    place.classList.toggle("stopped-now", stopped);
    say("stop-word", stopped ? t("STOPPED") : t("STOP"));
  }

  function judge() {
    if (document.hidden) return;
    const now = performance.now();
    const dead = now - who.bridge > SILENT_MS;
    place.dataset.watch = dead ? "dead" : "good";
    say("stop-dead", dead ? `${t("This STOP does not work: {why}.", { why })} ${remedy}` : "");
    hold(now - who.page > SILENT_MS || lineLost());
  }

  // ---- the rest of the page, while its service is away: what is pressed meanwhile must not come true later -------

  let line = null;
  let held = false;
  let focused = null;

  function lineLost() {
    if (line === null && window.socket && window.socket.connected) {
      line = window.socket;
      const emit = line.emit.bind(line);
      // "event" is what somebody pressed or typed: none while the page is held, though the line may stand or stand again
      line.emit = (...args) => (line.connected && !(held && args[0] === "event") ? emit(...args) : line);
    }
    return line !== null && !line.connected;
  }

  function hold(gone) {
    if (gone === held) return;
    held = gone;
    if (gone) focused = document.activeElement;
    for (const child of document.body.children) if (child !== place) child.inert = gone;
    say("page-lost", gone ? t("The server does not answer. The page shows old data, and only STOP can be pressed.") : "");
    if (!gone && focused && document.activeElement === document.body) focused.focus();
  }

  // ---- pressing it -----------------------------------------------------------------------------------------------

  function tell(text, tone) {
    window.clearInterval(fading);
    say("stop-result", text, tone);
    if (tone !== "good") return;
    let left = SHOWN_MS / 200;
    fading = window.setInterval(() => {
      left -= 1;
      if (left > 0 && !panelInSight()) return;
      window.clearInterval(fading);
      say("stop-result", "");
    }, 200);
  }

  // The red panel tells the same, once the page's own connection has brought it.
  function panelInSight() {
    const panel = part("stopped");
    const area = panel && panel.getBoundingClientRect();
    return Boolean(area) && area.height > 0 && area.bottom > 0 && area.top < window.innerHeight;
  }

  async function stop(how) {
    const press = ++presses;
    const pressed = performance.now();
    tell(t("Stopping …"), "busy");
    document.documentElement.dataset.stopping = how;  // until one has reached the robot: nothing leads away before
    try {
      const answer = await fetchWithin(`stop?how=${how}`, STOP_LIMIT_MS, { method: "POST", keepalive: true });
      const body = await answer.json().catch(() => ({}));
      if (press !== presses) return;
      if (!answer.ok) throw new Error(body.detail || body.title || `HTTP ${answer.status}`);
      if (!body.state || body.state.latched !== true) throw new Error(t("another program answers at this address"));
      show(true, ++asked);
      const answered = Math.round(performance.now() - pressed);
      const zero = body.first_zero_ms;
      tell(zero === null ? t("Stopped.")
        : t("Stopped: first zero velocity after {zero} ms, answered after {answered} ms",
          { zero: zero.toFixed(1), answered }), "good");
      delete document.documentElement.dataset.stopping;
    } catch (error) {
      if (press !== presses) return;
      tell(`${t("STOP DID NOT REACH THE ROBOT: {why}. Press again.", { why: error.message })} ${remedy}`, "bad");
    }
  }

  const onStop = (event) => event.target instanceof Element && event.target.closest('[data-atom="stop"]');

  // Going down is the press: nobody who means STOP should have to let go first, still on the button.
  document.addEventListener("pointerdown", (event) => { if (onStop(event)) stop("button"); }, true);
  // By keyboard or a screen reader there is no pointer: such a click counts none.
  document.addEventListener("click", (event) => { if (event.detail === 0 && onStop(event)) stop("button"); }, true);
  window.addEventListener("keydown", (event) => {
    if (event.key === "Escape" && !event.repeat) stop("escape");
  }, true);

  // ---- begin: here, and again where the page comes back to the screen ----------------------------------------------

  function begin() {
    if (document.hidden) return;
    who.bridge = who.page = performance.now();
    look();
  }

  begin();
  judge();
  window.setInterval(judge, LOOK_MS);
  window.setInterval(() => { if (!document.hidden) look(); }, ASK_MS);
  document.addEventListener("visibilitychange", begin);
  window.addEventListener("pageshow", (event) => { if (event.persisted) begin(); });
  // Last, so that the form does its work by itself wherever any line above failed.
  place.querySelector("form").addEventListener("submit", (event) => event.preventDefault());
})();
