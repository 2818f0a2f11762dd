// The live picture: the next is asked for when the last is drawn, so a slow viewer sees fewer frames, never old ones.
(() => {
  "use strict";
  const { t, part, pull } = window.atom;
  const OLD_MS = 3000;
  let drawnAt = 0;
  let why = "";

  async function draw(data) {
    if (typeof data === "string") {
      why = JSON.parse(data).trouble || "";
      freshness();
      return;
    }
    const length = new DataView(data).getUint32(0);
    const about = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, length)));
    const bitmap = await createImageBitmap(new Blob([new Uint8Array(data, 4 + length)], { type: "image/jpeg" }));
    const canvas = part("live");
    if (canvas) {
      paint(canvas, bitmap, about);
      const drawn = Number(canvas.dataset.frames || 0) + 1;
      canvas.dataset.frames = String(drawn);
      canvas.dataset.stamp = String(about.stamp_s);
      drawnAt = performance.now();
      why = "";
      freshness();
      document.dispatchEvent(new CustomEvent("atom-frame", { detail: about }));
    }
    bitmap.close();
    await new Promise((resolve) => { requestAnimationFrame(resolve); });
  }

  function paint(canvas, bitmap, about) {
    const width = Math.max(500, bitmap.width);
    const height = Math.round((width * bitmap.height) / bitmap.width);
    if (canvas.width !== width || canvas.height !== height) {
      canvas.width = width;
      canvas.height = height;
      canvas.style.setProperty("--ratio", String(width / height));
    }
    const pen = canvas.getContext("2d");
    pen.drawImage(bitmap, 0, 0, width, height);
    pen.font = "500 14px Roboto, system-ui, sans-serif";
    pen.textBaseline = "middle";
    for (const box of about.boxes) outline(pen, box, width, height);
    pen.fillStyle = "rgb(0 0 0 / 62%)";
    pen.fillRect(0, height - 26, width, 26);
    pen.fillStyle = "#fff";
    pen.fillText(about.line, 10, height - 13);
    const seen = about.boxes.map((box) => box.text).join(", ");
    canvas.setAttribute("aria-label", seen ? t("The robot sees: {what}", { what: seen }) : t("What the robot sees"));
  }

  function outline(pen, box, width, height) {
    const [left, top, right, bottom] = [box.at[0] * width, box.at[1] * height, box.at[2] * width, box.at[3] * height];
    const colour = box.target ? "#d11a1a" : "#157f37";
    pen.lineWidth = box.target ? 4 : 2.5;
    pen.strokeStyle = colour;
    pen.strokeRect(left, top, right - left, bottom - top);
    const wide = pen.measureText(box.text).width + 10;
    const x = Math.max(0, Math.min(left, width - wide));
    const y = Math.max(0, top - 20);
    pen.fillStyle = colour;
    pen.fillRect(x, y, wide, 20);
    pen.fillStyle = "#fff";
    pen.fillText(box.text, x + 5, y + 10.5);
  }

  function freshness() {
    const note = part("live-note");
    const canvas = part("live");
    if (!note || !canvas) return;
    const age = performance.now() - drawnAt;
    const old = drawnAt === 0 || age > OLD_MS;
    canvas.dataset.old = String(old);
    const what = drawnAt === 0 ? t("No picture yet") : t("Last picture {n} s ago", { n: Math.round(age / 1000) });
    const text = old ? (why ? `${what} – ${why}` : what) : "";
    if (note.textContent !== text) note.textContent = text;
  }

  window.setInterval(() => { if (!document.hidden) freshness(); }, 1000);
  pull("live/camera", draw, (trouble) => { why = trouble; freshness(); });
})();
