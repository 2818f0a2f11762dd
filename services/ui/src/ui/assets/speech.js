// Push to talk, only where the browser understands speech on this machine: no word leaves it.
(() => {
  "use strict";
  const { box, part } = window.atom;
  const spoken = () => document.documentElement.lang || "en-US";
  const Recognition = window.SpeechRecognition || window.webkitSpeechRecognition;

  async function here() {
    if (!Recognition || typeof Recognition.available !== "function") return false;
    try {
      return (await Recognition.available({ langs: [spoken()], processLocally: true })) === "available";
    } catch {
      return false;
    }
  }

  async function offer() {
    const button = part("mic");
    if (!button || !(await here())) return;
    button.hidden = false;
    let listening = null;
    const begin = () => {
      listening = new Recognition();
      listening.lang = spoken();
      listening.processLocally = true;
      listening.interimResults = true;
      listening.onresult = (event) => {
        const said = box();
        if (!said) return;
        said.value = Array.from(event.results, (result) => result[0].transcript).join(" ");
        said.dispatchEvent(new Event("input", { bubbles: true }));
      };
      listening.start();
    };
    const end = () => { if (listening) listening.stop(); listening = null; };
    const held = (event) => event.key === " " || event.key === "Enter";
    button.addEventListener("keydown", (event) => { if (held(event) && !event.repeat) begin(); });
    button.addEventListener("keyup", (event) => { if (held(event)) end(); });
    button.addEventListener("blur", end);
    button.addEventListener("pointerdown", begin);
    button.addEventListener("pointerup", end);
    button.addEventListener("pointercancel", end);
  }

  window.addEventListener("load", offer);
})();
