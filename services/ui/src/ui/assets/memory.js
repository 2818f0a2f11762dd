// Taking an exported memory back from a file.
(() => {
  "use strict";
  const { t, say, ask, ready } = window.atom;
  const IMPORT_LIMIT_MS = 90000;

  document.addEventListener("change", async (event) => {
    const input = event.target instanceof Element && event.target.closest('[data-atom="import"]');
    if (!input || input.files.length === 0) return;
    say("import-note", t("Importing …"));
    try {
      const answer = await ask("memory/import", IMPORT_LIMIT_MS, {
        method: "POST", headers: { "Content-Type": "application/octet-stream" }, body: input.files[0],
      });
      const said = await answer.json();
      say("import-note", answer.ok ? said.text : said.detail || said.title, answer.ok && said.ok ? "good" : "bad");
    } catch (error) {
      say("import-note", t("the server does not answer"), "bad");
    }
    input.value = "";
  });
  ready("memory");
})();
