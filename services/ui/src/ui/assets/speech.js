// Push to talk: hold the button or the space bar; the sound goes to this page's own server and is kept nowhere. Answers aloud.
(() => {
  "use strict";
  const { t, box, part, say, url, socketUrl, ask, ready } = window.atom;
  const RATE_HZ = 16000;
  const TAP_MS = 400;  // pressed for less: it was a tap, and the end of what is said ends it
  const NOT_HELD = "not held";
  const LAST_CHUNK_MS = 400;
  const SPEAK_MS = 20000;
  const SPOKEN_MAX = 500;
  let open = null;
  let newest = null;
  let playing = null;

  // settings of this browser

  const SETTINGS = ["at-once", "aloud"];
  const chosen = (name) => { const choice = part(`speech-${name}`); return choice !== null && choice.checked; };

  function kept(name, value) {
    try {
      if (value === undefined) return window.localStorage.getItem(`atom-speech-${name}`) === "yes";
      window.localStorage.setItem(`atom-speech-${name}`, value ? "yes" : "no");
    } catch { /* a browser that keeps nothing: as it stands on the page */ }
    return false;
  }

  // the microphone

  function whyNot() {
    if (!window.isSecureContext) {
      return t("The microphone needs https, or this page on the machine itself (localhost): a browser gives it to no other page. How to get https: docs/speech.md, “Phone and https”.");
    }
    if (!navigator.mediaDevices || !window.AudioWorkletNode) return t("This browser offers no microphone.");
    return "";
  }

  function show() {
    const live = open !== null && open.stream !== undefined && !open.shut;
    document.documentElement.dataset.microphone = live ? "open" : "shut";
    const button = part("mic");
    if (button) button.setAttribute("aria-pressed", String(live));
    const light = part("mic-light");
    if (light) light.hidden = !live;
    if (!live) level(0);
  }

  function level(value) {
    const meter = part("meter");
    if (meter) meter.style.setProperty("--level", String(Math.min(1, value * 4)));
  }

  async function begin() {
    if (open && !spoken(open)) return;
    if (open) end(open);  // what it said is read on: a stop in it is still one
    const why = whyNot();
    if (why) { say("heard", why, "bad"); return; }
    hush();
    offer([]);
    const mine = { held: true, ending: false, shut: false, done: false, stop: "", begun: performance.now(), early: [] };
    open = newest = mine;
    say("heard", t("Opening the microphone …"));
    try {
      connect(mine);
      const sound = { channelCount: 1, echoCancellation: true, noiseSuppression: true, autoGainControl: true };
      mine.stream = await navigator.mediaDevices.getUserMedia({ audio: sound });
      if (open !== mine || mine.shut) { shut(mine); return; }
      await record(mine);
      if (open !== mine || mine.shut) { shut(mine); return; }
      show();
      if (!mine.ending) say("heard", t("Listening …"));
    } catch (error) {
      const refused = error instanceof DOMException && error.name === "NotAllowedError";
      fail(mine, refused ? t("The browser was told not to give this page the microphone.")
        : t("The microphone does not work: {why}", { why: error.message || error.name || error }));
    }
  }

  async function record(mine) {
    const module = url("assets/microphone.js");
    let source;
    try {
      mine.context = new AudioContext({ sampleRate: RATE_HZ });
      source = mine.context.createMediaStreamSource(mine.stream);
    } catch {  // Firefox takes the microphone at the machine's own rate only
      if (mine.context) mine.context.close();
      mine.context = new AudioContext();
      source = mine.context.createMediaStreamSource(mine.stream);
    }
    await mine.context.audioWorklet.addModule(module);
    if (mine.shut) return;
    const node = new AudioWorkletNode(mine.context, "atom-microphone", { numberOfOutputs: 0 });
    node.port.onmessage = (message) => {
      if (mine.shut) return;
      level(message.data.level);
      send(mine, message.data.samples);
      if (mine.ending) end(mine);
    };
    source.connect(node);
  }

  function connect(mine) {
    const socket = new WebSocket(socketUrl("speech/listen?held=true"));
    mine.socket = socket;
    socket.onopen = () => { for (const early of mine.early.splice(0)) socket.send(early); };
    socket.onmessage = (message) => {
      const saying = JSON.parse(message.data);
      if (saying.heard_out) shut(mine);  // nobody listens any more, whatever it may turn out to mean
      if (saying.final) finish(mine, saying);
      else if (saying.stopped !== null) sayStopped(mine, saying);
      else if (saying.text && mine === newest) say("heard", saying.text);
    };
    socket.onclose = (closing) => {
      if (mine.done) return;
      fail(mine, t("The microphone is away: {why}", { why: closing.reason || t("the server does not answer") }));
      ask("assets/icon.svg", 1000).catch(() => {});  // a refused socket does not tell a script why; this does
    };
  }

  function send(mine, message) {
    if (mine.socket.readyState === WebSocket.OPEN) mine.socket.send(message);
    else if (mine.socket.readyState === WebSocket.CONNECTING) mine.early.push(message);
  }

  // Let go: the chunk under way is sent, then the end.
  function release() {
    const mine = open;
    if (!mine || !mine.held) return;
    mine.held = false;
    if (performance.now() - mine.begun >= TAP_MS) finishSpeaking(mine);
    else if (!spoken(mine)) send(mine, NOT_HELD);
  }

  // Nothing said into it is heard any more: the next press begins anew.
  const spoken = (mine) => mine.ending || mine.shut;

  function finishSpeaking(mine) {
    if (spoken(mine)) return;
    mine.ending = true;
    if (mine.context) window.setTimeout(() => end(mine), LAST_CHUNK_MS);
  }

  function end(mine) {
    if (mine.shut) return;
    shut(mine);
    send(mine, "");
    if (open === mine && !mine.stop) say("heard", t("Reading …"));
  }

  function shut(mine) {
    mine.shut = true;
    if (mine.stream) for (const track of mine.stream.getTracks()) track.stop();
    if (mine.context && mine.context.state !== "closed") mine.context.close();
    show();
  }

  function over(mine) {
    mine.done = true;
    shut(mine);
    mine.socket.close();
    if (open === mine) open = null;
    show();
  }

  function fail(mine, why) {
    if (mine.done) return;
    over(mine);
    say("heard", mine.stop ? `${mine.stop} ${why}` : why, "bad");
  }

  // what was heard

  // Kept: what fails later is told behind it.
  function sayStopped(mine, saying) {
    mine.stop = saying.stopped ? t("The robot was told to stop: “{words}”", { words: saying.text })
      : t("“{words}” did not reach the robot. Press STOP.", { words: saying.text });
    say("heard", mine.stop, "bad");
  }

  function finish(mine, saying) {
    over(mine);
    if (saying.stopped !== null) { sayStopped(mine, saying); return; }
    if (mine !== newest) return;  // spoken anew since
    if (!saying.text && !saying.command) { say("heard", t("Nothing was heard.")); return; }
    if (saying.offers.length > 0) {
      say("heard", saying.question || t("Which of these?"));
      offer(saying.offers);
      return;
    }
    say("heard", saying.question || t("Heard: “{words}”", { words: saying.text }));
    put(saying.command);
    if (chosen("at-once") && !saying.question) go();
  }

  function put(text) {
    const said = box();
    if (!said) return;
    said.value = text;
    said.dispatchEvent(new Event("input", { bubbles: true }));
  }

  const go = () => { const find = part("find"); if (find) find.click(); };

  function offer(offers) {
    const place = part("offers");
    if (!place) return;
    place.replaceChildren(...offers.map((one) => {
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = one.text;
      button.addEventListener("click", () => { offer([]); say("heard", ""); put(one.command); go(); });
      return button;
    }));
  }

  // aloud; never while the microphone is open: it would hear itself

  function hush() {
    if (playing) playing.pause();
    playing = null;
  }

  async function aloud(text) {
    if (!chosen("aloud") || open || !text) return;
    hush();
    try {
      const answer = await ask("speech/speak", SPEAK_MS, {
        method: "POST", headers: { "content-type": "application/json" },
        body: JSON.stringify({ text: text.slice(0, SPOKEN_MAX) }),
      });
      if (!answer.ok) throw new Error((await answer.json()).detail);
      const sound = URL.createObjectURL(await answer.blob());
      if (open) { URL.revokeObjectURL(sound); return; }
      hush();
      playing = new Audio(sound);
      playing.addEventListener("ended", () => URL.revokeObjectURL(sound), { once: true });
      await playing.play();
    } catch (error) {
      if (error instanceof DOMException && error.name === "AbortError") return;  // hushed
      say("heard", t("It cannot be read aloud: {why}", { why: error.message || error.name || error }), "bad");
    }
  }

  // button, space bar, touch

  const onMic = (event) => event.target instanceof Element && event.target.closest('[data-atom="mic"]');
  const taken = (element) => element instanceof Element
    && element.closest("input, textarea, select, button, a, summary, [contenteditable], [role=button], [role=tab], [role=slider], [role=dialog], [tabindex]:not([tabindex='-1'])") !== null;

  function press() {
    if (!open || spoken(open)) begin();
    else if (!open.held) finishSpeaking(open);
  }

  document.addEventListener("pointerdown", (event) => {
    const button = onMic(event);
    if (!button || event.button !== 0) return;
    event.preventDefault();
    button.setPointerCapture(event.pointerId);
    button.addEventListener("lostpointercapture", release, { once: true });
    press();
  });
  document.addEventListener("contextmenu", (event) => { if (onMic(event)) event.preventDefault(); });
  window.addEventListener("keydown", (event) => {
    const held = event.key === " " || (event.key === "Enter" && onMic(event));
    if (!held || event.ctrlKey || event.metaKey || event.altKey || !part("mic")) return;
    if (!onMic(event) && taken(event.target)) return;
    event.preventDefault();
    if (!event.repeat) press();
  });
  window.addEventListener("keyup", (event) => {
    if (event.key !== " " && event.key !== "Enter") return;
    if (onMic(event)) event.preventDefault();
    release();
  });
  window.addEventListener("blur", release);
  document.addEventListener("visibilitychange", () => { if (document.hidden && open) finishSpeaking(open); });
  window.addEventListener("pagehide", () => { if (open) over(open); });
  document.addEventListener("change", (event) => {
    for (const name of SETTINGS) if (event.target === part(`speech-${name}`)) kept(name, event.target.checked);
  });

  // The page draws its parts when it is connected: settings are put in as soon as they stand.
  const waiting = window.setInterval(() => {
    if (!part("mic")) return;
    window.clearInterval(waiting);
    for (const name of SETTINGS) { const choice = part(`speech-${name}`); if (choice) choice.checked = kept(name); }
    const why = whyNot();
    if (why) say("heard", why);
  }, 100);

  window.atom.aloud = aloud;
  ready("speech");
})();
