// What must work in the browser itself: STOP (also while the page's own connection is down) and the live picture.
(() => {
  "use strict";
  const PULL_MS_MIN = 200;
  const RETRY_MS = 1500;
  const OLD_MS = 3000;
  const STOP_TIMEOUT_MS = 8000;
  const part = (name) => document.querySelector(`[data-atom="${name}"]`);

  // ---- STOP ----------------------------------------------------------------------------------------------------
  let presses = 0;
  let fading = 0;

  function tell(text, tone) {
    const result = part("stop-result");
    if (!result) return;
    window.clearTimeout(fading);
    result.textContent = text;
    result.dataset.tone = tone;
    if (tone === "good") fading = window.setTimeout(() => { result.textContent = ""; }, 8000);
  }

  async function stop(how) {
    const press = ++presses;
    tell("Stopping …", "busy");
    try {
      const answer = await fetch(`/stop?how=${how}`, { method: "POST", signal: AbortSignal.timeout(STOP_TIMEOUT_MS) });
      const body = await answer.json();
      if (press !== presses) return;
      if (!answer.ok) throw new Error(body.detail || body.title || `HTTP ${answer.status}`);
      const ms = body.first_zero_ms;
      tell(ms === null ? "Stopped." : `Stopped: first zero velocity after ${ms.toFixed(1)} ms`, "good");
    } catch (error) {
      if (press !== presses) return;
      tell(`STOP DID NOT REACH THE ROBOT: ${error.message}. Press again, or use the robot's own button.`, "bad");
    }
  }

  document.addEventListener("click", (event) => {
    if (event.target instanceof Element && event.target.closest('[data-atom="stop"]')) stop("button");
  }, true);
  window.addEventListener("keydown", (event) => {
    if (event.key === "Escape" && !event.repeat) stop("escape");
  }, true);

  // ---- live picture: the next is pulled when the last is drawn, none in a hidden tab -----------------------------
  let after = null;
  let drawnAt = 0;
  let url = "";
  let asking = null;
  let next = 0;
  let trouble = "";

  async function pull() {
    const image = part("live");
    if (document.hidden) return;
    if (!image) { later(200); return; }
    const began = performance.now();
    asking = new AbortController();
    try {
      const answer = await fetch(`/live/frame?wait_s=5${after === null ? "" : `&after=${after}`}`,
        { signal: asking.signal, cache: "no-store" });
      if (answer.status === 200) {
        await draw(image, await answer.blob());
        after = Number(answer.headers.get("X-Stamp-S"));
        trouble = "";
      } else if (answer.status !== 204) {
        const body = await answer.json();
        throw new Error(body.detail || body.title);
      }
      later(PULL_MS_MIN - (performance.now() - began));
    } catch (error) {
      if (error.name === "AbortError") return;
      trouble = error.message;
      after = null;
      later(RETRY_MS);
    } finally {
      asking = null;
      freshness();
    }
  }

  async function draw(image, blob) {
    const old = url;
    url = URL.createObjectURL(blob);
    image.src = url;
    await image.decode();
    if (old) URL.revokeObjectURL(old);
    image.dataset.frames = String(Number(image.dataset.frames || 0) + 1);
    drawnAt = performance.now();
  }

  function later(ms) {
    window.clearTimeout(next);
    next = window.setTimeout(pull, Math.max(0, ms));
  }

  function freshness() {
    const note = part("live-note");
    const image = part("live");
    if (!note || !image) return;
    const age = performance.now() - drawnAt;
    const old = drawnAt === 0 || age > OLD_MS;
    image.dataset.old = String(old);
    const what = drawnAt === 0 ? "No picture yet" : `Last picture ${Math.round(age / 1000)} s ago`;
    const text = old ? (trouble ? `${what} – ${trouble}` : what) : "";
    if (note.textContent !== text) note.textContent = text;
  }

  document.addEventListener("visibilitychange", () => {
    if (document.hidden) {
      window.clearTimeout(next);
      if (asking) asking.abort();
    } else {
      after = null;
      later(0);
    }
  });
  window.setInterval(() => { if (!document.hidden) freshness(); }, 1000);
  later(0);
})();
