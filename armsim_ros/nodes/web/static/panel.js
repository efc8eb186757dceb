// Copyright 2026 armsim_ros authors
// SPDX-License-Identifier: Apache-2.0
// The panel: one websocket, the newest value of each section, and what is pressed.

import { setUpParts } from '/parts.js';
import { setUpPlots } from '/plots.js';

export const $ = (id) => document.getElementById(id);
export const state = {};
const listeners = {};
const RETRY = 800; // [ms]
const SLIDER_PAUSE = 40; // [ms]

/** Call a function whenever a section of the page's state comes in. */
export function on(names, work) {
  for (const name of names.split(' ')) (listeners[name] ??= []).push(work);
}

/** Ask the server for something. */
export function ask(what, values = {}) {
  if (socket?.readyState === WebSocket.OPEN) socket.send(JSON.stringify({ do: what, ...values }));
}

/** Return an element with attributes, handlers (onclick ...) and children. */
export function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith('on')) element.addEventListener(name.slice(2), value);
    else if (value === true) element.setAttribute(name, '');
    else if (value !== false && value != null) element.setAttribute(name, value);
  }
  element.append(...children.filter((child) => child != null));
  return element;
}

/** Fill a select with values, keeping its choice; entries are a text, or [value, text]. */
export function fill(select, entries, chosen) {
  const pairs = entries.map((entry) => (Array.isArray(entry) ? entry : [entry, entry]));
  const text = JSON.stringify(pairs);
  if (select.dataset.entries !== text) {
    select.dataset.entries = text;
    select.replaceChildren(...pairs.map(([value, label]) => make('option', { value }, label)));
  }
  if (chosen !== undefined && select.value !== chosen) select.value = chosen;
}

/** Return a function that passes its newest arguments on, not more often than every pause. */
export function eased(work, pause = SLIDER_PAUSE) {
  let waiting = null;
  let timer = null;
  const go = () => {
    timer = null;
    if (waiting) {
      const words = waiting;
      waiting = null;
      work(...words);
      timer = setTimeout(go, pause);
    }
  };
  return (...words) => {
    waiting = words;
    if (!timer) go();
  };
}

// ---- the connection -------------------------------------------------------------------------

function tabKey() {
  let key = sessionStorage.getItem('session');
  if (!key) {
    const bytes = crypto.getRandomValues(new Uint8Array(16));
    key = Array.from(bytes, (byte) => byte.toString(16).padStart(2, '0')).join('');
    sessionStorage.setItem('session', key);
  }
  return key;
}

const key = tabKey();
let socket = null;

function connect() {
  socket = new WebSocket(`${location.protocol === 'https:' ? 'wss' : 'ws'}://${location.host}/panel/${key}`);
  socket.onopen = () => {
    $('lost').hidden = true;
    // A server that was started again knows nothing of what this one knew.
    for (const name of Object.keys(state)) delete state[name];
    for (const work of new Set([...listeners.activity, ...listeners.plan])) work(state);
    ask('theme', { dark: dark.matches });
    loadScene(wasLost);
    wasLost = false;
  };
  socket.onmessage = (event) => {
    const news = JSON.parse(event.data);
    Object.assign(state, news);
    const due = new Set(Object.keys(news).flatMap((name) => listeners[name] ?? []));
    for (const work of due) work(state);
  };
  socket.onclose = () => {
    $('lost').hidden = false;
    wasLost = true;
    setTimeout(connect, RETRY);
  };
}

// ---- the scene ------------------------------------------------------------------------------

const dark = matchMedia('(prefers-color-scheme: dark)');
let sceneUrl = '';
let wasLost = false;

/** The scene connects again by itself only while it has the keyboard: load it anew instead. */
function loadScene(again = false) {
  const url = `/scene/${key}${dark.matches ? '?darkMode' : ''}`;
  if (url === sceneUrl && !again) return;
  sceneUrl = url;
  $('scene').src = url;
}

dark.addEventListener('change', () => {
  ask('theme', { dark: dark.matches });
  loadScene();
});
$('scene').addEventListener('load', () => {
  $('scene').contentWindow.addEventListener('keydown', onKey);
});

function onKey(event) {
  if (event.key === 'Escape') {
    event.preventDefault();
    ask('stop');
  }
}
addEventListener('keydown', onKey);

// ---- the status -----------------------------------------------------------------------------

on('programs activity result robot robot_error controllers me', () => {
  const { programs, activity, result, robot, me } = state;
  let level = 'ready';
  let text = 'Ready';
  const cures = (programs?.gone ?? []).map((one) => one.cure);
  if (!programs) {
    [level, text] = ['wait', 'connecting ...'];
  } else if (programs.gone.length) {
    [level, text] = ['error', programs.gone.map((one) => one.text).join(', ')];
  } else if (state.robot_error) {
    [level, text] = ['error', state.robot_error];
  } else if (programs?.waiting.length) {
    [level, text] = ['wait', `waiting for ${programs.waiting.join(', ')}`];
  } else if (activity) {
    const owner = activity.session === me ? '' : ` (session ${activity.session})`;
    level = 'busy';
    const times = `${activity.elapsed.toFixed(1)} of ${activity.total.toFixed(1)} s`;
    text = activity.what === 'planning' ? `Planning ...${activity.elapsed ? ` ${times} at most` : ''}${owner}`
      : `Executing ${times}${owner}`;
  } else if (result && !result.good && result.text !== 'stopped') {
    [level, text] = ['error', result.text];
  }
  $('status').dataset.level = level;
  $('status-text').textContent = text;
  showProgress(level === 'busy' ? activity : null);
  $('cures').textContent = cures.join('; ');
  $('robot-name').textContent = robot?.name || 'armsim';
  document.title = robot?.name ? `${robot.name} · armsim` : 'armsim';
  $('result').textContent = result && (result.good || result.text === 'stopped') ? result.text : '';
  $('result').dataset.good = String(Boolean(result?.good));
  const active = (state.controllers ?? []).filter((one) => one.state === 'active');
  const space = (one) => one.manager.split('/').slice(1, -1).join('/');
  const arms = new Set((state.controllers ?? []).map((one) => one.manager)).size;
  $('controllers-line').textContent = active.length
    ? `active: ${active.slice(0, 4).map((one) => `${arms > 1 ? `${space(one)}/` : ''}${one.name}`).join(', ')}${active.length > 4 ? ' ...' : ''}` : '';
  const free = !activity && !programs?.gone.length && !programs?.waiting.length && state.goal?.group;
  for (const id of ['plan', 'plan-execute']) $(id).disabled = !free;
  $('execute').disabled = !free || !state.plan;
  if (robot?.complaints.length && !onKey.told) {
    onKey.told = true;
    showNote(robot.complaints[0], 'info');
  }
});
on('goal plan', () => listeners.activity[0]());

/** How far a motion is; nobody knows that of a plan, so its bar just runs. */
function showProgress(activity) {
  $('progress').classList.toggle('resting', !activity);
  $('progress').setAttribute('aria-label', activity?.what ?? '');
  if (activity?.what === 'planning') $('progress').removeAttribute('value');
  else $('progress').value = activity?.total ? activity.elapsed / activity.total : 0;
}

on('clock', ({ clock }) => {
  $('clock').textContent = clock
    ? `${new Date(clock.time * 1000).toISOString().slice(11, 21)} sim time${clock.factor == null ? '' : ` · ${clock.factor.toFixed(2)}×`}` : '';
});

function showNote(text, level) {
  $('note').hidden = !text;
  $('note').dataset.level = level;
  $('note').firstElementChild.textContent = text;
}
on('note', ({ note }) => note && showNote(note.text, note.level));
$('note').querySelector('button').onclick = () => showNote('', '');

// ---- plan -----------------------------------------------------------------------------------

const group = () => state.robot?.groups.find((one) => one.name === state.goal?.group);

on('robot goal', () => {
  const { robot, goal } = state;
  if (!robot || !goal) return;
  fill($('group'), robot.groups.map((one) => one.name), goal.group);
  $('row-group').hidden = robot.groups.length < 2;
  const states = group()?.states ?? [];
  const tip = group()?.tip;
  fill($('goal-state'), [
    ['', 'joints as set'], ...states.map((name) => [name, name]), ['random valid', 'random valid'],
    ['current', 'current'], ...(tip ? [['drag the tool', 'drag the tool']] : [])], goal.state);
  fill($('start-state'), ['current', ...states, 'where the ghost is'], goal.start);
  $('verdict').textContent = goal.text;
  $('verdict').dataset.kind = goal.kind;
  $('verdict').dataset.shown = String(Boolean(goal.text));
  drawJoints();
});

$('group').onchange = () => ask('group', { name: $('group').value });
$('goal-state').onchange = () => $('goal-state').value && ask('goal_state', { name: $('goal-state').value });
$('start-state').onchange = () => ask('start_state', { name: $('start-state').value });

const sendJoints = eased((values) => ask('joints', { values }));
const wanted = {};

function unitOf(joint) {
  if (!joint.turns) return { factor: 1, step: 0.001, digits: 3, name: 'm' };
  return $('radians').checked ? { factor: 1, step: 0.01, digits: 3, name: 'rad' }
    : { factor: 180 / Math.PI, step: 1, digits: 1, name: '°' };
}

function drawJoints() {
  const joints = group()?.joints ?? [];
  const mark = JSON.stringify([state.goal.group, joints, $('radians').checked]);
  if ($('joints').dataset.mark !== mark) {
    $('joints').dataset.mark = mark;
    $('joints').replaceChildren(...joints.map((joint) => {
      const unit = unitOf(joint);
      const ends = [joint.lower * unit.factor, joint.upper * unit.factor];
      const limits = { min: ends[0], max: ends[1], 'data-joint': joint.name };
      const set = (event) => {
        const value = Number(event.target.value) / unit.factor;
        if (event.target.value === '' || !Number.isFinite(value)) return;
        wanted[joint.name] = value;
        showJoint(joint, value, event.target);
        sendJoints({ ...wanted });
      };
      return make('label', { class: 'joint', title: `${joint.name} [${unit.name}]` },
        make('span', {}, joint.name),
        make('span', { class: 'range' },
          make('input', { type: 'range', step: 'any', 'aria-label': joint.name, ...limits, oninput: set }),
          make('span', { class: 'ends', 'aria-hidden': 'true' }, make('span', {}, ends[0].toFixed(unit.digits > 2 ? 2 : 0) + unit.name),
            make('span', {}, ends[1].toFixed(unit.digits > 2 ? 2 : 0) + unit.name))),
        make('input', { type: 'number', step: unit.step, 'aria-label': `${joint.name} [${unit.name}]`, ...limits, onchange: set }));
    }));
  }
  for (const joint of joints) showJoint(joint, state.goal.positions[joint.name], document.activeElement);
}

function showJoint(joint, value, except) {
  const unit = unitOf(joint);
  for (const input of $('joints').querySelectorAll(`[data-joint="${CSS.escape(joint.name)}"]`)) {
    if (input !== except) {
      input.value = input.type === 'range' ? value * unit.factor : (value * unit.factor).toFixed(unit.digits);
    }
  }
}
document.addEventListener('focusout', () => { for (const name in wanted) delete wanted[name]; });

on('pipelines', ({ pipelines }) => {
  fill($('pipeline'), [['', 'default'], ...[...new Set(pipelines.map((one) => one.id))].map((id) => [id, id || 'default'])]);
  fillPlanners();
});

function fillPlanners() {
  const id = $('pipeline').value;
  const names = (state.pipelines ?? []).filter((one) => !id || one.id === id).flatMap((one) => one.planners);
  fill($('planner'), [['', 'default'], ...new Set(names)]);
}
$('pipeline').onchange = fillPlanners;

/** What the last thing came to is no answer to what is asked now. */
function forgetResult() {
  state.result = null;
  listeners.result[0]();
}

function plan(execute) {
  forgetResult();
  ask('plan', {
    execute, straight: $('straight').checked, pipeline: $('pipeline').value, planner: $('planner').value,
    speed: $('speed').value / 100, acceleration: $('acceleration').value / 100,
    planning_time: Math.min(120, Math.max(0.1, Number($('planning-time').value) || 5)),
  });
}
$('plan').onclick = () => plan(false);
$('plan-execute').onclick = () => plan(true);
$('execute').onclick = () => {
  forgetResult();
  ask('execute');
};
$('stop').onclick = () => ask('stop');
$('reset-view').onclick = () => ask('reset_view');
$('frames').onchange = () => ask('frames', { shown: $('frames').checked });
on('frames', ({ frames }) => { $('frames').checked = frames; });

for (const id of ['speed', 'acceleration']) {
  const show = () => { $(id).parentElement.querySelector('output').textContent = `${$(id).value} %`; };
  $(id).addEventListener('input', show);
  remember($(id), 'value', show);
}
remember($('planning-time'), 'value');
remember($('radians'), 'checked');
$('radians').addEventListener('change', () => state.goal && drawJoints());

// ---- the path -------------------------------------------------------------------------------

const scrub = eased((time) => ask('scrub', { time }), 33);

on('plan', ({ plan: now }) => {
  $('plan-box').hidden = !now;
  if (!now) return;
  $('time').max = now.duration;
  $('time').step = now.duration / 500 || 0.01;
  showTime(now.duration, now.duration);
});
on('replay', ({ replay, plan: now }) => now && showTime(replay, now.duration));

function showTime(time, total) {
  $('time').value = time;
  $('time-value').textContent = `${time.toFixed(2)} s`;
  $('time').setAttribute('aria-valuetext', `${time.toFixed(2)} of ${total.toFixed(2)} s`);
}
$('time').oninput = () => {
  const time = Number($('time').value);
  showTime(time, state.plan.duration);
  scrub(time);
};
$('replay').onclick = () => ask('replay', { loop: $('loop').checked });
$('loop').onchange = () => ask('replay', { loop: $('loop').checked });
$('clear').onclick = () => ask('clear');

// ---- what the browser remembers -------------------------------------------------------------

function remember(element, property, changed = () => {}) {
  const name = `armsim.${element.id}`;
  const kept = localStorage.getItem(name);
  if (kept !== null) element[property] = property === 'checked' ? kept === 'true' : kept;
  element.addEventListener('change', () => localStorage.setItem(name, element[property]));
  changed();
}

for (const fold of document.querySelectorAll('details')) {
  const name = `armsim.${fold.id}`;
  const kept = localStorage.getItem(name);
  fold.open = kept === null ? 'open' in fold.dataset : kept === 'open';
  fold.addEventListener('toggle', () => localStorage.setItem(name, fold.open ? 'open' : 'folded'));
}

setUpParts();
setUpPlots();
connect();
