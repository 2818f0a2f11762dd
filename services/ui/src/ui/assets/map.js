// The map's marks on a canvas, and what a click on the map means: go there, look there.
(() => {
  "use strict";
  const { t, part, say, pull, ask: request, ready } = window.atom;
  const SHARP = 4;  // canvas pixels a map cell
  const ROBOT_M = 0.34;
  const OPEN_M = 1.8;  // round a point to come: as far as things are made out well
  const RAYS = 60;
  const ASK_LIMIT_MS = 40000;  // a turn answers when it is done
  const belief = window.atom.belief;  // none where its script did not load
  const rooms = window.atom.rooms;
  const floor = { of: "", free: null };
  const scene = {};
  let picked = null;

  function colours(element) {
    const style = getComputedStyle(element);
    const pick = (name) => style.getPropertyValue(`--${name}`).trim();
    return { ink: pick("ink"), card: pick("card"), trail: pick("trail"), todo: pick("todo"), done: pick("done"),
      target: pick("target"), laser: pick("laser"), thing: pick("thing"), gone: pick("todo"),
      likely: pick("likely") };
  }

  function draw(data) {
    const changed = JSON.parse(data);
    if (Object.keys(changed).length === 0) return;
    Object.assign(scene, changed);
    if (belief && changed.belief) belief.take(changed.belief);
    if (rooms && changed.rooms) rooms.take(changed.rooms);
    paint();
  }

  function paint() {
    if (!scene.map) return;
    const canvas = part("map");
    if (!canvas) {  // the page is still being built
      window.setTimeout(paint, 100);
      return;
    }
    const [width, height] = [scene.map.width * SHARP, scene.map.height * SHARP];
    if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; }
    const pen = canvas.getContext("2d");
    const colour = colours(canvas);
    pen.setTransform(SHARP, 0, 0, SHARP, 0, 0);
    pen.clearRect(0, 0, scene.map.width, scene.map.height);
    pen.lineJoin = pen.lineCap = "round";
    const unit = Math.max(scene.map.width, scene.map.height) / 110;
    const believed = Boolean(belief) && belief.draw(pen, colour, unit);
    if (rooms) rooms.draw(pen, scene.map, !believed);
    if (scene.memory) remembered(pen, colour, unit);
    if (scene.paths) paths(pen, colour, unit);
    if (scene.search) search(pen, colour, unit);
    if (scene.laser) laser(pen, colour, unit);
    if (scene.robot && scene.robot.at) robot(pen, colour);
    canvas.dataset.draws = String(Number(canvas.dataset.draws || 0) + 1);
    canvas.dataset.robot = scene.robot && scene.robot.at ? scene.robot.metres.join(",") : "";
    canvas.dataset.fresh = String(Boolean(scene.robot && scene.robot.fresh));
    canvas.dataset.laser = String(scene.laser ? scene.laser.points.length / 2 : 0);
    canvas.dataset.things = String(scene.memory ? scene.memory.objects.length : 0);
    canvas.dataset.belief = String(believed);
    canvas.dataset.rooms = String(scene.rooms ? scene.rooms.names.length : 0);
    canvas.dataset.trail = String(scene.paths ? scene.paths.trail.length / 2 : 0);
  }

  function line(pen, points) {
    pen.beginPath();
    for (let i = 0; i < points.length; i += 2) pen.lineTo(points[i], points[i + 1]);
    pen.stroke();
  }

  function dot(pen, at, radius) {
    pen.beginPath();
    pen.arc(at[0], at[1], radius, 0, 7);
    pen.fill();
  }

  function remembered(pen, colour, unit) {
    pen.strokeStyle = colour.todo;
    pen.lineWidth = unit * 0.3;
    pen.globalAlpha = 0.45;
    for (const [x, y, turn] of scene.memory.views) {
      pen.beginPath();
      pen.moveTo(x, y);
      pen.lineTo(x + Math.cos(turn) * unit * 2, y + Math.sin(turn) * unit * 2);
      pen.stroke();
    }
    for (const thing of scene.memory.objects) {
      pen.globalAlpha = thing.gone ? 0.5 : 0.35 + 0.65 * thing.belief;
      pen.fillStyle = pen.strokeStyle = thing.gone ? colour.gone : colour.thing;
      const [x, y] = thing.at;
      const r = unit * 1.1;
      pen.beginPath();
      pen.rect(x - r, y - r, 2 * r, 2 * r);
      if (thing.gone || thing.hours > 24) { pen.lineWidth = unit * 0.5; pen.stroke(); } else pen.fill();
    }
    pen.globalAlpha = 1;
  }

  function paths(pen, colour, unit) {
    pen.strokeStyle = colour.trail;
    pen.lineWidth = unit * 0.65;
    pen.globalAlpha = 0.75;
    line(pen, scene.paths.trail);
    pen.setLineDash([unit * 1.2, unit * 1.2]);
    line(pen, scene.paths.planned);
    pen.setLineDash([]);
    pen.globalAlpha = 1;
    if (scene.paths.goal) {
      pen.lineWidth = unit * 0.5;
      pen.beginPath();
      pen.arc(...scene.paths.goal, unit * 1.8, 0, 7);
      pen.stroke();
    }
  }

  function search(pen, colour, unit) {
    pen.fillStyle = colour.todo;
    stillOpen(pen, scene.search.todo);
    pen.globalAlpha = 0.8;
    scene.search.todo.forEach((at) => dot(pen, at, unit));
    pen.globalAlpha = 1;
    pen.fillStyle = colour.done;
    scene.search.done.forEach((at) => dot(pen, at, unit));
    if (scene.search.todo.length) {
      pen.strokeStyle = colour.trail;
      pen.lineWidth = unit * 0.4;
      pen.beginPath();
      pen.arc(...scene.search.todo[0], unit * 1.5, 0, 7);
      pen.stroke();
    }
    if (scene.search.target) {
      pen.fillStyle = colour.target;
      pen.globalAlpha = 0.25;
      dot(pen, scene.search.target, unit * 3);
      pen.globalAlpha = 1;
      dot(pen, scene.search.target, unit * 1.3);
    }
  }

  // The area still open: the free floor in sight of the points to come, one wash however much they overlap.
  function stillOpen(pen, points) {
    const free = freeFloor();
    if (!free || points.length === 0) return;
    const reach = OPEN_M * (scene.map.robot_px / ROBOT_M);
    pen.globalAlpha = 0.2;
    pen.beginPath();
    for (const [x, y] of points) {
      for (let ray = 0; ray < RAYS; ray++) {
        const [across, down] = [Math.cos((ray * 2 * Math.PI) / RAYS), Math.sin((ray * 2 * Math.PI) / RAYS)];
        let far = 0;
        while (far < reach && free(x + far * across, y + far * down)) far += 1;
        pen[ray ? "lineTo" : "moveTo"](x + far * across, y + far * down);
      }
      pen.closePath();
    }
    pen.fill();
  }

  // Read once a version from the picture below: free floor is the part that shines through a little.
  function freeFloor() {
    const image = part("stage") && part("stage").querySelector("img");
    if (!image || !image.complete || !image.naturalWidth) return null;
    if (floor.of !== image.src) {
      const { naturalWidth: width, naturalHeight: height } = image;
      const pen = new OffscreenCanvas(width, height).getContext("2d");
      pen.drawImage(image, 0, 0);
      const pixels = pen.getImageData(0, 0, width, height).data;
      floor.of = image.src;
      floor.free = (x, y) => {
        if (x < 0 || y < 0 || x >= width || y >= height) return false;
        const alpha = pixels[4 * (Math.floor(y) * width + Math.floor(x)) + 3];
        return alpha > 0 && alpha < 255;
      };
    }
    return floor.free;
  }

  function laser(pen, colour, unit) {
    pen.fillStyle = colour.laser;
    const r = unit * 0.32;
    const points = scene.laser.points;
    for (let i = 0; i < points.length; i += 2) pen.fillRect(points[i] - r, points[i + 1] - r, 2 * r, 2 * r);
  }

  function robot(pen, colour) {
    const size = Math.max(scene.map.robot_px / 2, scene.map.width / 60);
    pen.save();
    pen.globalAlpha = scene.robot.fresh ? 1 : 0.35;
    pen.translate(...scene.robot.at);
    pen.rotate(scene.robot.turn);
    pen.fillStyle = colour.ink;
    pen.strokeStyle = colour.card;
    pen.lineWidth = size * 0.25;
    pen.beginPath();
    pen.arc(0, 0, size, 0, 7);
    pen.fill();
    pen.stroke();
    pen.fillStyle = colour.trail;
    pen.beginPath();
    pen.moveTo(size * 1.9, 0);
    pen.lineTo(size * 0.5, -size * 0.85);
    pen.lineTo(size * 0.5, size * 0.85);
    pen.closePath();
    pen.fill();
    pen.stroke();
    pen.restore();
  }

  // ---- a click on the map ---------------------------------------------------------------------------------------

  async function ask(what, body) {
    say("place-note", what === "go" ? t("Planning a path …") : what === "look" ? t("Turning …") : "");
    try {
      const answer = await request(`place/${what}`, ASK_LIMIT_MS, {
        method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body || {}),
      });
      const said = await answer.json();
      say("place-note", answer.ok ? said.text : said.detail || said.title, answer.ok && said.ok ? "good" : "bad");
    } catch (error) {
      say("place-note", t("the server does not answer"), "bad");
    }
    window.setTimeout(() => say("place-note", ""), 8000);
  }

  function close() {
    const here = part("here");
    if (here) here.hidden = true;
    picked = null;
  }

  document.addEventListener("click", (event) => {
    if (!(event.target instanceof Element)) return;
    const button = event.target.closest("[data-here]");
    if (button) {
      if (button.dataset.here !== "close" && picked) ask(button.dataset.here, picked);
      close();
      return;
    }
    if (event.target.closest('[data-atom="halt"]')) { ask("halt"); return; }
    const canvas = event.target.closest('[data-atom="map"]');
    if (!canvas || !scene.map) { if (!event.target.closest('[data-atom="here"]')) close(); return; }
    const area = canvas.getBoundingClientRect();
    const [across, down] = [(event.clientX - area.left) / area.width, (event.clientY - area.top) / area.height];
    picked = { x_px: across * scene.map.width, y_px: down * scene.map.height, version: scene.map.version };
    const here = part("here");
    here.hidden = false;
    here.style.left = `${Math.min(72, Math.max(28, across * 100))}%`;
    here.style.top = `${Math.min(80, down * 100)}%`;
    here.querySelector("button").focus();
  });

  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", paint);
  if (belief) belief.onChange(paint);
  if (rooms) rooms.onChange(paint);
  pull("live/scene", draw, () => {}, () => `next${belief ? belief.asked() : ""}`);
  ready("map");
})();
