// STOP works in the browser itself: also while the page's own connection is down.
(() => {
  "use strict";
  const { t, part } = window.atom;
  const STOP_TIMEOUT_MS = 8000;
  const SHOWN_MS = 8000;
  const LOOK_MS = 200;
  let presses = 0;
  let fading = 0;

  function tell(text, tone) {
    const result = part("stop-result");
    if (!result) return;
    window.clearInterval(fading);
    result.textContent = text;
    result.dataset.tone = tone;
    if (tone !== "good") return;
    let left = SHOWN_MS / LOOK_MS;
    fading = window.setInterval(() => {
      left -= 1;
      if (left > 0 && !panelInSight()) return;
      window.clearInterval(fading);
      result.textContent = "";
    }, LOOK_MS);
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
    try {
      const answer = await fetch(`/stop?how=${how}`, { method: "POST", signal: AbortSignal.timeout(STOP_TIMEOUT_MS) });
      const body = await answer.json();
      if (press !== presses) return;
      if (!answer.ok) throw new Error(body.detail || body.title || `HTTP ${answer.status}`);
      const answered = Math.round(performance.now() - pressed);
      const zero = body.first_zero_ms;
      tell(zero === null ? t("Stopped.")
        : t("Stopped: first zero velocity after {zero} ms, answered after {answered} ms",
          { zero: zero.toFixed(1), answered }), "good");
    } catch (error) {
      if (press !== presses) return;
      tell(t("STOP DID NOT REACH THE ROBOT: {why}. Press again, or use the robot's own button.", { why: error.message }),
        "bad");
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
})();
