// Copyright 2026 armsim_ros authors
// SPDX-License-Identifier: Apache-2.0
//
// Move the arm from JavaScript, in node or in a page:
//
//     npm install roslib
//     armsim bringup bridge:=true
//     node bridge_roslib.mjs
//
// Reads a topic in each encoding, calls services, sends a trajectory to the controller, and
// serves a service and an action. The first argument is another port.

import * as ROSLIB from 'roslib';

const port = process.argv[2] ?? '9090';
const ros = new ROSLIB.Ros({url: `ws://127.0.0.1:${port}`});
const CONTROLLER = '/sunday/arm_joint_controller/follow_joint_trajectory';
const TARGET = 0.4;

function once(options) {
  const topic = new ROSLIB.Topic({ros, ...options});
  return new Promise((resolve) => topic.subscribe((message) => {
    topic.unsubscribe();
    resolve(message);
  }));
}

function call(name, serviceType, request) {
  const service = new ROSLIB.Service({ros, name, serviceType});
  return new Promise((resolve, reject) => service.callService(request, resolve, reject, 10));
}

async function jointStates(compression = 'none') {
  const message = await once(
    {name: '/sunday/joint_states', messageType: 'sensor_msgs/JointState', compression});
  return compression === 'cbor-raw' ? message : new Map(
    message.name.map((name, index) => [name, message.position[index]]));
}

async function move() {
  const joints = await jointStates();
  const names = [...joints.keys()].filter((name) => name.startsWith('joint_'));
  const positions = names.map((name) => name === 'joint_1' ? TARGET : joints.get(name));
  const action = new ROSLIB.Action(
    {ros, name: CONTROLLER, actionType: 'control_msgs/action/FollowJointTrajectory'});
  const result = await new Promise((resolve, reject) => action.sendGoal(
    {trajectory: {joint_names: names, points: [{positions, time_from_start: {sec: 2, nanosec: 0}}]}},
    resolve, undefined, reject));
  const after = await jointStates();
  return [result.error_code, Math.abs(after.get('joint_1') - TARGET)];
}

async function serve() {
  const name = '/from_javascript';
  const service = new ROSLIB.Service({ros, name, serviceType: 'std_srvs/SetBool'});
  service.advertise((request, response) => {
    response.success = request.data;
    response.message = 'from JavaScript';
    return true;
  });
  await new Promise((resolve) => ros.getTopics(resolve));  // what was sent before is done
  const answer = await call(name, 'std_srvs/SetBool', {data: true});
  service.unadvertise();
  return answer.message;
}

await new Promise((resolve, reject) => {
  ros.on('connection', resolve);
  ros.on('error', reject);
});
for (const compression of ['png', 'cbor', 'cbor-raw']) {
  await jointStates(compression);
  console.log(`joint states as ${compression}`);
}
const raw = await new Promise((resolve, reject) => ros.getTopicsAndRawTypes(resolve, reject));
console.log(`${raw.topics.length} topics, ${raw.typedefs_full_text.filter(Boolean).length} texts`);
console.log(`a service answers ${await serve()}`);
const [code, error] = await move();
console.log(`error code ${code}, ${(error * 1e3).toFixed(1)} mrad from the target`);
ros.close();
process.exit(code === 0 && error < 0.01 ? 0 : 1);
