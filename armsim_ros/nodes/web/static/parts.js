// Copyright 2026 armsim_ros authors
// SPDX-License-Identifier: Apache-2.0
// Scene, Controllers, Simulation and Jog.

import { $, ask, eased, fill, make, on, state } from '/panel.js';

const JOG_RATE = 50; // [ms]
const SIZES = { box: ['x', 'y', 'z'], sphere: ['radius'], cylinder: ['height', 'radius'] };
const LARGEST_FILE = 16 << 20;

// ---- Scene ----------------------------------------------------------------------------------

const sendChange = eased((change) => ask('change', change), 60);

function three(label, names, values, step, changed) {
  const inputs = values.map((value, index) => make('input', {
    type: 'number', step, value, title: `${label} ${names[index]}`, 'aria-label': `${label} ${names[index]}`,
    onchange: () => {
      const numbers = inputs.map((input) => Number(input.value));
      if (numbers.every(Number.isFinite)) changed(numbers);
    } }));
  return make('div', { class: 'three' }, make('span', {}, label), ...inputs);
}

/** Roll, pitch, yaw [degrees] of a quaternion xyzw, and back: rotations about fixed axes. */
function toAngles([x, y, z, w]) {
  return [Math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)),
    Math.asin(Math.max(-1, Math.min(1, 2 * (w * y - z * x)))),
    Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))].map((angle) => Math.round(angle * 18000 / Math.PI) / 100);
}

function toQuaternion(angles) {
  const [[cr, sr], [cp, sp], [cy, sy]] = angles.map((angle) => [Math.cos(angle * Math.PI / 360), Math.sin(angle * Math.PI / 360)]);
  return [sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy, cr * cp * cy + sr * sp * sy];
}

function drawObjects() {
  const { objects = [], chosen = '' } = state;
  if ($('objects').contains(document.activeElement) && document.activeElement.type === 'number'
    && $('objects').dataset.names === JSON.stringify([objects.map((one) => [one.id, one.link]), chosen])) return;
  $('objects').dataset.names = JSON.stringify([objects.map((one) => [one.id, one.link]), chosen]);
  $('objects').replaceChildren(...objects.map((one) => {
    const open = one.id === chosen;
    const id = one.id;
    return make('div', { class: open ? 'item chosen' : 'item', 'data-object': id },
      make('div', { class: 'name' }, make('span', {}, id), make('span', { class: 'dim' }, one.link ? `on ${one.link}` : one.kind)),
      open && !one.link ? three('Place [m]', 'xyz', one.xyz, 0.01, (xyz) => sendChange({ id, xyz })) : null,
      open && !one.link ? three('Turn [°]', ['roll', 'pitch', 'yaw'], toAngles(one.turn), 5, (angles) => sendChange({ id, turn: toQuaternion(angles) })) : null,
      open && !one.link && SIZES[one.kind] ? three('Size [m]', SIZES[one.kind], one.size, 0.01, (size) => sendChange({ id, size })) : null,
      make('div', { class: 'buttons' },
        one.link ? null : make('button', { type: 'button', onclick: () => ask('select', { id: open ? '' : id }) }, open ? 'Done' : 'Move'),
        make('button', { type: 'button', onclick: () => ask(one.link ? 'detach' : 'attach', { id }) }, one.link ? 'Detach' : 'Attach'),
        make('button', { type: 'button', onclick: () => ask('remove', { id }) }, 'Remove')));
  }));
  if (!objects.length) $('objects').replaceChildren(make('p', { class: 'dim' }, 'No objects.'));
}

function asBase64(bytes) {
  let text = '';
  for (let at = 0; at < bytes.length; at += 0x8000) text += String.fromCharCode(...bytes.subarray(at, at + 0x8000));
  return btoa(text);
}

function chosenFile(input, work) {
  input.addEventListener('change', async () => {
    const file = input.files[0];
    input.value = '';
    if (!file) return;
    if (file.size > LARGEST_FILE) {
      alertLine(`${file.name} is larger than ${LARGEST_FILE >> 20} MiB`);
      return;
    }
    work(file, new Uint8Array(await file.arrayBuffer()));
  });
}

function alertLine(text) {
  $('note').hidden = false;
  $('note').firstElementChild.textContent = text;
}

function setUpScene() {
  on('objects chosen', drawObjects);
  for (const button of document.querySelectorAll('[data-add]')) {
    button.onclick = () => (button.dataset.add === 'mesh' ? $('mesh-file').click() : ask('add', { shape: button.dataset.add }));
  }
  chosenFile($('mesh-file'), (file, bytes) => ask('add_mesh', { name: file.name, data: asBase64(bytes) }));
  chosenFile($('scene-file'), (_file, bytes) => ask('load_scene', { text: new TextDecoder().decode(bytes) }));
  $('load-scene').onclick = () => $('scene-file').click();
  on('octomap', ({ octomap }) => {
    $('octomap').hidden = !octomap;
    if (octomap) $('octomap-cells').textContent = `${octomap.cells} cells of ${+(octomap.resolution * 100).toFixed(2)} cm`;
  });
  $('clear-octomap').onclick = () => ask('clear_octomap');
  $('save-scene').onclick = () => ask('save_scene');
  on('saved_scene', ({ saved_scene: text }) => {
    const url = URL.createObjectURL(new Blob([text], { type: 'application/json' }));
    make('a', { href: url, download: 'scene.json' }).click();
    setTimeout(() => URL.revokeObjectURL(url), 5000);
  });
  on('goal', ({ goal }) => {
    $('allow').hidden = !goal.touching.length;
    $('allow').title = goal.touching.map((pair) => pair.join(' and ')).join(', ');
  });
  $('allow').onclick = () => ask('allow', { pairs: state.goal.touching });
}

// ---- Controllers ----------------------------------------------------------------------------

function setUpControllers() {
  on('controllers', ({ controllers }) => {
    const arms = new Set(controllers.map((one) => one.manager)).size;
    const label = (one) => (arms > 1 ? `${one.manager.split('/').slice(1, -1).join('/')}/${one.name}` : one.name);
    $('controllers').replaceChildren(...controllers.map((one) => {
      const active = one.state === 'active';
      return make('div', { class: 'item', 'data-controller': one.name, title: one.joints.join(', ') },
        make('div', { class: 'name' }, make('span', {}, label(one)), make('span', { class: `state-${one.state}` }, one.state)),
        make('div', { class: 'dim' }, `${one.type}${one.joints.length ? ` · ${one.joints.join(', ')}` : ''}`),
        make('progress', { max: 1, value: 0, hidden: true }),
        active || one.state === 'inactive' ? make('div', { class: 'buttons' }, make('button', { type: 'button',
          onclick: () => ask('switch', { manager: one.manager, name: one.name, active: !active }) }, active ? 'Deactivate' : 'Activate')) : null);
    }));
    if (!controllers.length) $('controllers').replaceChildren(make('p', { class: 'dim' }, 'waiting for a controller_manager'));
  });
  on('activity controllers', ({ activity, plan }) => {
    for (const item of $('controllers').querySelectorAll('[data-controller]')) {
      const one = state.controllers?.find((other) => other.name === item.dataset.controller);
      const bar = item.querySelector('progress');
      bar.hidden = !(activity?.what === 'executing' && /trajectory/i.test(one?.type) && one.state === 'active'
        && (!plan || plan.joints.some((joint) => one.joints.includes(joint))));
      if (!bar.hidden) bar.value = activity.total ? activity.elapsed / activity.total : 0;
    }
  });
}

// ---- Simulation -----------------------------------------------------------------------------

/** Simulated time per wall time; the last is as fast as it goes. */
const SPEEDS = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 0];

function showSpeed(factor) {
  const text = factor ? `${Number(factor.toPrecision(3))}×` : 'full';
  $('simulation-speed').parentElement.querySelector('output').textContent = text;
  $('simulation-speed').setAttribute('aria-valuetext', text);
}

function nearestSpeed(factor) {
  if (!factor) return SPEEDS.length - 1;
  const distance = (one) => (one ? Math.abs(Math.log(one / factor)) : Infinity);
  return SPEEDS.reduce((best, one, index) => (distance(one) < distance(SPEEDS[best]) ? index : best), 0);
}

function setUpSafety() {
  on('safety', ({ safety }) => {
    $('part-safety').hidden = !safety.length;
    $('safety').replaceChildren(...safety.map((one) => {
      const stopped = one.safety !== 'NORMAL' && one.safety !== 'REDUCED';
      const button = (label, what, disabled) => make('button', { type: 'button', disabled, 'data-safety': what, onclick: () => ask('safety', { arm: one.arm, what }) }, label);
      return make('div', { class: 'item' },
        make('div', { class: 'name' }, make('span', {}, `${one.safety.replaceAll('_', ' ').toLowerCase()}, ${one.mode}`), make('span', { class: 'dim' }, one.arm)),
        one.cause ? make('div', { class: 'dim' }, one.cause) : null,
        make('div', { class: 'buttons' }, button('Stop', 'stop', stopped), button('Clear', 'clear', !stopped)));
    }));
  });
}

function setUpSimulation() {
  on('simulation', ({ simulation }) => {
    $('part-simulation').hidden = !simulation;
    if (!simulation) return;
    const served = (name) => simulation.served.includes(name);
    $('pause').hidden = $('play').hidden = !served('/set_simulation_state');
    $('step').hidden = !served('/step_simulation');
    $('reset').hidden = !served('/reset_simulation');
    $('pause').disabled = simulation.state === 'paused';
    $('play').disabled = simulation.state === 'playing';
    $('step').disabled = simulation.state !== 'paused';
    $('row-simulation-speed').hidden = simulation.speed == null;
    if (simulation.speed != null && document.activeElement !== $('simulation-speed')) {
      $('simulation-speed').value = nearestSpeed(simulation.speed);
      showSpeed(simulation.speed);
    }
    $('entities').replaceChildren(...simulation.entities.map((one) => make('div', { class: 'name dim' }, `${one.name}: ${one.xyz.join(', ')} m`)));
    $('row-camera').hidden = !simulation.cameras.length;
    fill($('camera'), [['', 'none'], ...simulation.cameras.map((name) => [name, name])], simulation.camera);
  });
  for (const what of ['pause', 'play', 'step', 'reset']) $(what).onclick = () => ask('simulation', { what });
  $('simulation-speed').oninput = () => showSpeed(SPEEDS[$('simulation-speed').value]);
  $('simulation-speed').onchange = () => ask('simulation_speed', { factor: SPEEDS[$('simulation-speed').value] });
  $('camera').onchange = () => ask('camera', { topic: $('camera').value });
  on('picture', ({ picture }) => {
    $('picture').hidden = !picture;
    if (picture) $('picture').src = picture;
  });
}

// ---- Jog ------------------------------------------------------------------------------------

function held(text, label, command) {
  let timer = null;
  const stop = () => {
    if (!timer) return;
    clearInterval(timer);
    timer = null;
    ask('jog', { ...command, share: 0 });
  };
  const start = (event) => {
    if (timer || (event.type === 'keydown' && ![' ', 'Enter'].includes(event.key))) return;
    event.preventDefault();
    ask('jog', command);
    timer = setInterval(() => ask('jog', command), JOG_RATE);
  };
  const button = make('button', { type: 'button', 'aria-label': label, onpointerdown: start, onkeydown: start,
    onpointerup: stop, onpointercancel: stop, onpointerleave: stop, onkeyup: stop, onblur: stop, oncontextmenu: (event) => event.preventDefault() }, text);
  addEventListener('blur', stop);
  return button;
}

function jogRow(name, command) {
  return make('div', { class: 'jog-row' }, make('span', {}, name),
    held('−', `${name} backwards`, { ...command, share: -0.5 }), held('+', `${name} forwards`, { ...command, share: 0.5 }));
}

function setUpJog() {
  on('servo_status', ({ servo_status: text }) => { $('jog-status').textContent = text ?? ''; });
  on('servo robot goal', ({ servo, robot, goal }) => {
    $('part-jog').hidden = !servo;
    const joints = robot?.groups.find((one) => one.name === goal?.group)?.joints ?? [];
    const mark = JSON.stringify([servo, joints.map((one) => one.name)]);
    if (!servo || $('jog').dataset.mark === mark) return;
    $('jog').dataset.mark = mark;
    $('jog').replaceChildren(
      ...['x', 'y', 'z', 'rx', 'ry', 'rz'].map((axis) => jogRow(`tool ${axis}`, { axis })),
      ...joints.map((joint) => jogRow(joint.name, { joint: joint.name })));
  });
}

export function setUpParts() {
  setUpScene();
  setUpControllers();
  setUpSafety();
  setUpSimulation();
  setUpJog();
}
