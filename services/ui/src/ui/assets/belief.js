// The map's layer of what the search holds probable: its switch, its cells in the page's colour, the words beside it.
(() => {
  "use strict";
  const { t, part, say, ready } = window.atom;
  const STRONGEST = 0.85;
  const KEPT = "atom-belief";
  let shown = kept();
  let told = null;
  let cells = null;  // the picture last read, with how it lies on the map
  let changed = () => {};

  function take(data) {
    told = data;
    words();
    if (!data.png) { cells = null; return; }
    const image = new Image();
    image.src = data.png;
    image.decode().then(() => {
      if (told !== data) return;  // a newer one has come
      cells = { image, fit: data.fit, view: data.view, tinted: null, colour: "" };
      changed();
    }, () => {});
  }

  // The page may load itself anew after a broken connection: what was switched on stays on.
  function kept() {
    try { return window.sessionStorage.getItem(KEPT) === "shown"; } catch { return false; }
  }

  function keep() {
    try { window.sessionStorage.setItem(KEPT, shown ? "shown" : ""); } catch { /* where it may not be kept */ }
  }

  function words() {
    part("belief-words").hidden = !shown;
    part("belief-switch").setAttribute("aria-pressed", String(shown));
    say("belief-absent", told ? told.absent : "");
    say("belief-peak", told ? told.peak : "");
    say("belief-why", told ? told.why : t("Asking what the search holds probable …"));
  }

  // `colours`: likely, card. `unit`: a small length of this map. True where there was something to draw.
  function draw(pen, colours, unit) {
    if (part("belief-words").hidden === shown) words();
    if (!shown || !cells) return false;
    pen.save();
    pen.imageSmoothingEnabled = false;
    pen.globalAlpha = STRONGEST;
    pen.transform(...cells.fit);
    if (cells.colour !== colours.likely) Object.assign(cells, tinted(cells.image, colours.likely));
    pen.drawImage(cells.tinted, 0, 0);
    pen.restore();
    if (cells.view) next(pen, cells.view, colours, unit);
    return true;
  }

  function tinted(image, colour) {
    const { naturalWidth: width, naturalHeight: height } = image;
    const canvas = new OffscreenCanvas(width, height);
    const pen = canvas.getContext("2d");
    pen.drawImage(image, 0, 0);
    pen.globalCompositeOperation = "source-in";
    pen.fillStyle = colour;
    pen.fillRect(0, 0, width, height);
    return { tinted: canvas, colour };
  }

  function next(pen, view, colours, unit) {
    const [x, y] = view.at;
    for (const [colour, width] of [[colours.card, unit * 1.2], [colours.likely, unit * 0.6]]) {
      pen.strokeStyle = colour;
      pen.lineWidth = width;
      pen.beginPath();
      for (const turn of view.turns) {
        pen.moveTo(x + Math.cos(turn) * unit * 2, y + Math.sin(turn) * unit * 2);
        pen.lineTo(x + Math.cos(turn) * unit * 5, y + Math.sin(turn) * unit * 5);
      }
      pen.moveTo(x + unit * 2, y);
      pen.arc(x, y, unit * 2, 0, 7);
      pen.stroke();
    }
  }

  document.addEventListener("click", (event) => {
    if (!(event.target instanceof Element && event.target.closest('[data-atom="belief-switch"]'))) return;
    shown = !shown;
    keep();
    words();
    changed();
  });

  window.atom.belief = { take, draw, asked: () => (shown ? " belief" : ""), onChange: (paint) => { changed = paint; } };
  ready("belief");
})();
