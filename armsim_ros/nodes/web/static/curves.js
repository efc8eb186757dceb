// Copyright 2026 armsim_ros authors
// SPDX-License-Identifier: Apache-2.0
// One picture of curves over time on a canvas; of the page and of 'armsim plot --to out.html'.

/** Draw lines [{x, y, color, dash, width}] over time, and bounds, y values of limits. */
export function draw(canvas, lines, bounds, unit) {
  const ratio = devicePixelRatio || 1;
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  if (!width) return;
  canvas.width = width * ratio;
  canvas.height = height * ratio;
  const pen = canvas.getContext('2d');
  pen.scale(ratio, ratio);
  const style = getComputedStyle(document.documentElement);
  const color = (name) => style.getPropertyValue(name).trim();
  pen.fillStyle = color('--card');
  pen.fillRect(0, 0, width, height);
  pen.font = '13px system-ui, sans-serif';
  const values = lines.flatMap((line) => line.y);
  if (!values.length) return;
  let low = Math.min(...values);
  let high = Math.max(...values);
  const span = high - low || Math.max(Math.abs(high), 1e-3);
  // Limits that the motion comes near to are in the picture, far ones would only flatten it.
  for (const bound of bounds) {
    if (bound > low - 1.2 * span && bound < high + 1.2 * span) {
      low = Math.min(low, bound);
      high = Math.max(high, bound);
    }
  }
  [low, high] = [low - 0.06 * (high - low || span), high + 0.06 * (high - low || span)];
  const end = Math.max(...lines.map((line) => line.x.at(-1) ?? 0)) || 1;
  const box = { left: 52, right: width - 8, top: 8, bottom: height - 22 };
  const x = (time) => box.left + (box.right - box.left) * time / end;
  const y = (value) => box.bottom - (box.bottom - box.top) * (value - low) / (high - low);
  pen.lineWidth = 1;
  pen.textBaseline = 'middle';
  for (const value of ticks(low, high, 4)) {
    pen.strokeStyle = color('--line');
    pen.beginPath(); pen.moveTo(box.left, y(value)); pen.lineTo(box.right, y(value)); pen.stroke();
    pen.fillStyle = color('--dim');
    pen.textAlign = 'right';
    pen.fillText(String(Number(value.toPrecision(4))), box.left - 6, y(value));
  }
  pen.textAlign = 'center';
  for (const time of ticks(0, end, 5)) pen.fillText(`${Number(time.toPrecision(3))}`, x(time), height - 9);
  pen.textAlign = 'right';
  pen.fillText('s', box.right, height - 9);
  pen.save();
  pen.beginPath(); pen.rect(box.left, box.top - 2, box.right - box.left, box.bottom - box.top + 4); pen.clip();
  pen.strokeStyle = color('--stop');
  pen.setLineDash([5, 4]);
  for (const bound of new Set(bounds)) {
    pen.beginPath(); pen.moveTo(box.left, y(bound)); pen.lineTo(box.right, y(bound)); pen.stroke();
  }
  for (const line of lines) {
    pen.strokeStyle = line.color;
    pen.lineWidth = line.width ?? 1.8;
    pen.setLineDash(line.dash ?? []);
    pen.beginPath();
    line.x.forEach((time, index) => (index ? pen.lineTo(x(time), y(line.y[index])) : pen.moveTo(x(time), y(line.y[0]))));
    pen.stroke();
  }
  pen.restore();
  canvas.setAttribute('aria-label', `${canvas.dataset.title} over time, from ${low.toPrecision(3)} to ${high.toPrecision(3)} ${unit}`);
}

function ticks(low, high, count) {
  const rough = (high - low) / count;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((one) => one * power).find((one) => one >= rough);
  const found = [];
  for (let value = Math.ceil(low / step) * step; value <= high + 1e-9 * step; value += step) found.push(Math.abs(value) < 1e-12 ? 0 : value);
  return found;
}
