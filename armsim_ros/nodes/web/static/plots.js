// Copyright 2026 armsim_ros authors
// SPDX-License-Identifier: Apache-2.0
// Curves of motions on canvases, with what is needed to read them; PNG and CSV of both.

import { draw } from '/curves.js';
import { $, make, on, state } from '/panel.js';

const COLORS = ['#2f6fde', '#e8710a', '#1e9e5a', '#c5369d', '#7b57d6', '#a58500', '#0a9bb5', '#d64545'];
const KINDS = { position: 'Position', velocity: 'Velocity', acceleration: 'Acceleration' };
const LIMITS = { position: ['lower', 'upper'], velocity: ['velocity'], acceleration: ['acceleration'] };
const UNITS = { position: 'rad', velocity: 'rad/s', acceleration: 'rad/s²' };
const hidden = new Set();

/** Return the pictures to draw: title, unit, lines, bounds. */
function pictures() {
  if ($('plot-what').value === 'trace') {
    const joints = Object.entries(state.trace ?? {}).filter(([name]) => !hidden.has(name));
    const colored = joints.map(([name, one]) => ({ ...one, color: colorOf(name) }));
    return joints.length ? [
      { title: 'Position, desired (dashed) and actual', unit: 'rad', bounds: [], lines: colored.flatMap((one) => [
        { x: one.times, y: one.desired, color: one.color, dash: [4, 4], width: 1.2 },
        { x: one.times, y: one.actual, color: one.color }]) },
      { title: 'Error', unit: 'mrad', bounds: [], lines: colored.map((one) => (
        { x: one.times, y: one.error.map((value) => 1000 * value), color: one.color })) },
    ] : [];
  }
  const { plan } = state;
  if (!plan) return [];
  return Object.entries(KINDS).map(([kind, title]) => {
    const shown = plan.joints.map((name, index) => [name, index]).filter(([name]) => !hidden.has(name));
    const bounds = shown.flatMap(([name]) => LIMITS[kind].flatMap((which) => {
      const value = plan.limits[name]?.[which];
      if (value == null) return [];
      return kind === 'position' ? [value] : [value, -value];
    }));
    return { title, unit: UNITS[kind], bounds, lines: shown.map(([name, index]) => (
      { x: plan.times, y: plan[kind][index], color: colorOf(name) })) };
  });
}

function names() {
  return $('plot-what').value === 'trace' ? Object.keys(state.trace ?? {}) : state.plan?.joints ?? [];
}

function colorOf(name) {
  return COLORS[names().indexOf(name) % COLORS.length];
}

function redraw() {
  if (!$('part-motion').open) return;
  const all = pictures();
  if (!all.length) {
    $('plots').replaceChildren(make('p', { class: 'dim' }, $('plot-what').value === 'trace'
      ? 'Execute a motion to see what the controllers report.' : 'Plan a motion to see its curves.'));
    $('legend').replaceChildren();
    return;
  }
  const mark = JSON.stringify(all.map((one) => one.title));
  if ($('plots').dataset.mark !== mark || !$('plots').querySelector('canvas')) {
    $('plots').dataset.mark = mark;
    $('plots').replaceChildren(...all.map((one) => make('figure', {},
      make('figcaption', {}, `${one.title} [${one.unit}]`), make('canvas', { role: 'img', 'data-title': one.title }))));
  }
  $('plots').querySelectorAll('canvas').forEach((canvas, index) => draw(canvas, all[index].lines, all[index].bounds, all[index].unit));
  const legend = JSON.stringify(names());
  if ($('legend').dataset.mark !== legend || !$('legend').childElementCount) {
    $('legend').dataset.mark = legend;
    $('legend').replaceChildren(...names().map((name) => make('label', {},
      make('input', { type: 'checkbox', checked: !hidden.has(name), onchange: (event) => {
        if (event.target.checked) hidden.delete(name); else hidden.add(name);
        redraw();
      } }), make('i', { style: `background:${colorOf(name)}` }), name)));
  }
}

function save(name, url) {
  const link = make('a', { href: url, download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(url), 5000);
}

function png() {
  const canvases = [...$('plots').querySelectorAll('canvas')];
  if (!canvases.length) return;
  const sheet = make('canvas');
  sheet.width = Math.max(...canvases.map((one) => one.width));
  const gap = 22 * (devicePixelRatio || 1);
  sheet.height = canvases.reduce((sum, one) => sum + one.height + gap, 0);
  const pen = sheet.getContext('2d');
  pen.fillStyle = getComputedStyle(document.documentElement).getPropertyValue('--card');
  pen.fillRect(0, 0, sheet.width, sheet.height);
  pen.fillStyle = getComputedStyle(document.documentElement).getPropertyValue('--text');
  pen.font = `${0.62 * gap}px system-ui, sans-serif`;
  let top = 0;
  for (const canvas of canvases) {
    pen.fillText(canvas.dataset.title, 8, top + 0.75 * gap);
    pen.drawImage(canvas, 0, top + gap);
    top += canvas.height + gap;
  }
  sheet.toBlob((blob) => save('motion.png', URL.createObjectURL(blob)));
}

function csv() {
  const rows = [];
  if ($('plot-what').value === 'trace') {
    rows.push(['joint', 'time', 'desired', 'actual', 'error']);
    for (const [name, one] of Object.entries(state.trace ?? {})) {
      one.times.forEach((time, index) => rows.push([name, time, one.desired[index], one.actual[index], one.error[index]]));
    }
  } else if (state.plan) {
    rows.push(['time', ...Object.keys(KINDS).flatMap((kind) => state.plan.joints.map((name) => `${name} ${kind}`))]);
    state.plan.times.forEach((time, index) => rows.push([time, ...Object.keys(KINDS).flatMap((kind) => state.plan[kind].map((row) => row[index]))]));
  }
  if (rows.length) save('motion.csv', URL.createObjectURL(new Blob([rows.map((row) => row.join(',')).join('\n') + '\n'], { type: 'text/csv' })));
}

export function setUpPlots() {
  on('plan', () => { $('plot-what').value = 'plan'; redraw(); });
  on('trace', () => { $('plot-what').value = 'trace'; redraw(); });
  $('plot-what').onchange = redraw;
  $('part-motion').addEventListener('toggle', redraw);
  $('png').onclick = png;
  $('csv').onclick = csv;
  addEventListener('resize', redraw);
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', redraw);
}
