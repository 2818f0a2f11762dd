// The map's rooms: a tint on the canvas, names above it, and what a click on a name asks for: another name.
(() => {
  "use strict";
  const { t, part, say, ask, ready } = window.atom;
  const ASK_LIMIT_MS = 10000;
  const NOTE_MS = 8000;
  let told = null;
  let cells = null;  // the picture last read, with how it lies on the map
  let asked = null;  // the room whose name is being asked for
  let written = "";
  let changed = () => {};

  function take(data) {
    told = data;
    if (!data.png) { cells = null; return; }
    const image = new Image();
    image.src = data.png;
    image.decode().then(() => {
      if (told !== data) return;  // a newer one has come
      cells = { image, fit: data.fit };
      changed();
    }, () => {});
  }

  // `map`: width and height in pixels of its picture. The tint is left out where another layer colours the floor.
  function draw(pen, map, tint) {
    names(map);
    if (!cells || !tint) return;
    pen.save();
    pen.imageSmoothingEnabled = false;
    pen.transform(...cells.fit);
    pen.drawImage(cells.image, 0, 0);
    pen.restore();
  }

  // Written anew where they are others: a name that stays keeps the focus it has.
  function names(map) {
    const place = part("room-names");
    if (!place || !told) return;
    const now = JSON.stringify([told.names, map.width, map.height]);
    if (now === written && place.childElementCount === told.names.length) return;
    written = now;
    const focused = place.contains(document.activeElement) ? document.activeElement.dataset.room : "";
    place.replaceChildren(...told.names.map((room) => button(room, map)));
    if (focused) place.querySelector(`[data-room="${focused}"]`)?.focus();
  }

  function button(room, map) {
    const made = document.createElement("button");
    made.type = "button";
    made.className = `room-name by-${room.by}`;
    made.dataset.room = String(room.id);
    made.textContent = room.by === "contents" ? t("{name}?", { name: room.name }) : room.name;
    made.title = t("{name}: {why}. Click to name it.", { name: room.name, why: room.why });
    made.setAttribute("aria-label", made.title);
    made.style.left = `${(100 * room.at[0]) / map.width}%`;
    made.style.top = `${(100 * room.at[1]) / map.height}%`;
    return made;
  }

  function open(room, beside) {
    asked = room;
    const form = part("room-ask");
    form.hidden = false;
    form.style.left = `${Math.min(68, Math.max(32, parseFloat(beside.style.left)))}%`;
    form.style.top = `${Math.min(70, parseFloat(beside.style.top))}%`;
    say("room-why", t("{name}: {why}", { name: room.name, why: room.why }));
    form.querySelector('[data-naming="unname"]').hidden = room.by !== "person";
    const input = form.querySelector("input");
    input.value = room.by === "nobody" ? "" : room.name;
    input.focus();
    input.select();
  }

  function close() {
    const form = part("room-ask");
    if (form) form.hidden = true;
    asked = null;
  }

  async function name(room, text) {
    say("place-note", "");
    try {
      const answer = await ask(`rooms/${room.id}/name`, ASK_LIMIT_MS, {
        method: "PUT", headers: { "Content-Type": "application/json" }, body: JSON.stringify({ name: text }),
      });
      const said = await answer.json();
      say("place-note", answer.ok ? said.text : said.detail || said.title, answer.ok && said.ok ? "good" : "bad");
    } catch (error) {
      say("place-note", t("the server does not answer"), "bad");
    }
    window.setTimeout(() => say("place-note", ""), NOTE_MS);
  }

  function save() {
    const text = part("room-ask").querySelector("input").value.trim();
    if (asked && text) name(asked, text);
    close();
  }

  document.addEventListener("click", (event) => {
    if (!(event.target instanceof Element)) return;
    const clicked = event.target.closest("[data-room]");
    if (clicked && told) {
      const room = told.names.find((one) => String(one.id) === clicked.dataset.room);
      if (room) open(room, clicked);
      return;
    }
    const does = event.target.closest("[data-naming]");
    if (!does) { if (!event.target.closest('[data-atom="room-ask"]')) close(); return; }
    if (does.dataset.naming === "save") { save(); return; }
    if (does.dataset.naming === "unname" && asked) name(asked, "");
    close();
  });

  document.addEventListener("keydown", (event) => {
    if (event.key !== "Enter" || !(event.target instanceof Element)) return;
    if (event.target.closest('[data-atom="room-ask"]') && event.target.tagName === "INPUT") save();
  });

  window.atom.rooms = { take, draw, onChange: (paint) => { changed = paint; } };
  ready("rooms");
})();
