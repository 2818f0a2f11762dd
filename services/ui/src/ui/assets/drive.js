// Driving by hand: the stick speaks ten times a second while it is held, and falls silent the moment it is not.
(() => {
  "use strict";
  const { t, part, say, socketUrl, ready } = window.atom;
  const PERIOD_MS = 100;
  const SILENT_MS = 1000;
  const KEYS = {
    w: [1, 0], arrowup: [1, 0], s: [-1, 0], arrowdown: [-1, 0],
    a: [0, 1], arrowleft: [0, 1], d: [0, -1], arrowright: [0, -1],
  };
  const held = new Set();
  let socket = null;
  let dragged = null;
  let moving = false;
  let heardAt = 0;

  const on = () => socket !== null;

  function wanted() {
    if (dragged) return dragged;
    let [forward, turn] = [0, 0];
    for (const key of held) { forward += KEYS[key][0]; turn += KEYS[key][1]; }
    return { forward: Math.max(-1, Math.min(1, forward)), turn: Math.max(-1, Math.min(1, turn)) };
  }

  function speak() {
    if (!socket) return;
    const stick = wanted();
    const still = stick.forward === 0 && stick.turn === 0;
    if (still && !moving) return;
    if (!moving) heardAt = performance.now();
    moving = !still;
    if (moving && performance.now() - heardAt > SILENT_MS) say("drive-note", t("the line to the robot is silent"), "bad");
    if (socket.readyState !== WebSocket.OPEN) return;
    socket.send(JSON.stringify({ t_ms: performance.now(), forward: stick.forward, turn: stick.turn }));
    if (still) say("drive-note", "");
  }

  function letGo() {
    held.clear();
    dragged = null;
    place(0, 0);
    speak();
  }

  function place(forward, turn) {
    const knob = part("knob");
    if (knob) knob.style.translate = `calc(-50% + ${-turn * 42}px) calc(-50% + ${-forward * 42}px)`;
  }

  function open() {
    const opened = new WebSocket(socketUrl("teleop"));
    socket = opened;
    opened.onmessage = (message) => {
      heardAt = performance.now();
      const driven = JSON.parse(message.data);
      if (!moving) return;
      const speed = t("{v} m/s, {w} °/s", {
        v: driven.linear_x.toFixed(2), w: Math.round((driven.angular_z * 180) / Math.PI),
      });
      say("drive-note", driven.text ? `${speed} – ${driven.text}` : speed, driven.ok ? "good" : "bad");
    };
    opened.onclose = (closing) => {
      if (socket !== opened) return;
      close();
      say("drive-note", closing.reason || t("the line to the robot broke"), "bad");
    };
    show();
  }

  function close() {
    letGo();
    const closing = socket;
    socket = null;
    if (closing) closing.close();
    show();
  }

  function show() {
    const button = part("drive-switch");
    if (button) button.setAttribute("aria-pressed", String(on()));
    const stick = part("stick");
    if (stick) stick.hidden = !on();
    say("drive-note", "");
  }

  const typing = (element) => element instanceof Element
    && element.closest("input, textarea, select, [contenteditable], [role=tab], [role=slider]") !== null;

  document.addEventListener("click", (event) => {
    if (event.target instanceof Element && event.target.closest('[data-atom="drive-switch"]')) (on() ? close : open)();
  });
  window.addEventListener("keydown", (event) => {
    const key = event.key.toLowerCase();
    if (!on() || !(key in KEYS) || event.ctrlKey || event.metaKey || event.altKey || typing(event.target)) return;
    event.preventDefault();
    if (held.has(key)) return;
    held.add(key);
    const { forward, turn } = wanted();
    place(forward, turn);
    speak();
  });
  window.addEventListener("keyup", (event) => {
    if (!held.delete(event.key.toLowerCase())) return;
    const { forward, turn } = wanted();
    place(forward, turn);
    speak();
  });

  document.addEventListener("pointerdown", (event) => {
    const stick = event.target instanceof Element && event.target.closest('[data-atom="stick"]');
    if (!stick || !on()) return;
    event.preventDefault();
    stick.setPointerCapture(event.pointerId);
    drag(stick, event);
    const move = (moved) => drag(stick, moved);
    const end = () => {
      stick.removeEventListener("pointermove", move);
      letGo();
    };
    stick.addEventListener("pointermove", move);
    stick.addEventListener("lostpointercapture", end, { once: true });
  });

  function drag(stick, event) {
    const area = stick.getBoundingClientRect();
    const reach = area.width / 2 - 22;
    let x = (event.clientX - area.left - area.width / 2) / reach;
    let y = (event.clientY - area.top - area.height / 2) / reach;
    const far = Math.max(1, Math.hypot(x, y));
    [x, y] = [x / far, y / far];
    dragged = { forward: -y, turn: -x };
    place(-y, -x);
    speak();
  }

  window.addEventListener("blur", letGo);
  document.addEventListener("visibilitychange", () => { if (document.hidden && on()) close(); });
  window.setInterval(speak, PERIOD_MS);
  ready("drive");
})();
