// Push to talk, only where the browser understands speech on this machine: no word leaves it.
(() => {
  "use strict";
  const { part } = window.atom;
  const Recognition = window.SpeechRecognition || window.webkitSpeechRecognition;

  async function here() {
    if (!Recognition || typeof Recognition.available !== "function") return false;
    try {
      return (await Recognition.available({ langs: ["en-US"], processLocally: true })) === "available";
    } catch {
      return false;
    }
  }

  async function offer() {
    const button = part("mic");
    if (!button || !(await here())) return;
    button.hidden = false;
    let listening = null;
    button.addEventListener("pointerdown", () => {
      listening = new Recognition();
      listening.lang = "en-US";
      listening.processLocally = true;
      listening.interimResults = true;
      listening.onresult = (event) => {
        const box = document.querySelector("[data-atom-say] input, input[data-atom-say]");
        if (!box) return;
        box.value = Array.from(event.results, (result) => result[0].transcript).join(" ");
        box.dispatchEvent(new Event("input", { bubbles: true }));
      };
      listening.start();
    });
    const end = () => { if (listening) listening.stop(); listening = null; };
    button.addEventListener("pointerup", end);
    button.addEventListener("pointercancel", end);
  }

  window.addEventListener("load", offer);
})();
