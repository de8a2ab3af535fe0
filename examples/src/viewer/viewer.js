'use strict';
// The build in WebGL2. All lengths are millimetres, all times seconds; matrices are columns of four.
(section => {
const find = name => section.querySelector('.view-' + name);
const make = (parent, name) => parent.appendChild(document.createElement(name));
const header = JSON.parse(find('header').textContent);
const canvas = find('canvas');
const gl = canvas.getContext('webgl2', { antialias: true, powerPreference: 'high-performance' });
if (!gl || typeof DecompressionStream === 'undefined') {
  find('frame').hidden = find('time').hidden = true;
  find('missing').hidden = false;
  find('missing').textContent = 'This browser shows no WebGL2 or cannot inflate data: the pictures below show the build.';
  return;
}

// ---- numbers: columns of differences, low bytes first, deflated
async function unpack() {
  const element = find('columns'), raw = atob(element.textContent.trim()), bytes = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) bytes[i] = raw.charCodeAt(i);
  element.remove();
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate'));
  const all = new Uint8Array(await new Response(stream).arrayBuffer()), columns = {};
  let at = 0;
  for (const [name, width, count] of header.columns) {
    const numbers = new { 1: Uint8Array, 2: Uint16Array, 4: Uint32Array }[width](count);
    for (let i = 0, last = 0; i < count; i++) {
      let difference = all[at + i];
      for (let byte = 1; byte < width; byte++) difference |= all[at + byte * count + i] << 8 * byte;
      numbers[i] = last = last + difference | 0;
    }
    columns[name] = numbers;
    at += width * count;
  }
  return columns;
}

// ---- vectors and matrices
const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const add = (a, b, s = 1) => [a[0] + b[0] * s, a[1] + b[1] * s, a[2] + b[2] * s];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = a => { const n = Math.hypot(...a) || 1; return [a[0] / n, a[1] / n, a[2] / n]; };
const IDENTITY = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
function times(a, b) {
  const of = (c, r) => [0, 1, 2, 3].reduce((sum, k) => sum + a[4 * k + r] * b[4 * c + k], 0);
  return Array.from({ length: 16 }, (_, at) => of(at >> 2, at & 3));
}
const moved = (m, p) => [0, 1, 2].map(r => dot([m[r], m[4 + r], m[8 + r]], p) + m[12 + r]);
// A frame whose z axis is `z`, stretched by `wide` across and `tall` along.
function frame(origin, z, wide = 1, tall = 1) {
  const x = unit(cross(Math.abs(z[0]) < 0.8 ? [1, 0, 0] : [0, 1, 0], z)), y = cross(z, x);
  return [...x.map(c => c * wide), 0, ...y.map(c => c * wide), 0, ...z.map(c => c * tall), 0, ...origin, 1];
}
function turned([x, y, z, w], origin) {
  return [1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w), 0, 2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w), 0,
    2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y), 0, ...origin, 1];
}

// ---- programs
function program(vertex, fragment) {
  const made = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, '#version 300 es\nprecision highp float;\nprecision highp int;\n' + text);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    gl.attachShader(made, shader);
  }
  gl.linkProgram(made);
  const places = {};
  for (let i = 0; i < gl.getProgramParameter(made, gl.ACTIVE_UNIFORMS); i++) {
    const name = gl.getActiveUniform(made, i).name;
    places[name] = gl.getUniformLocation(made, name);
  }
  return { made, places };
}
// A bead is two triangles that face the eye, shaded as an elliptic cylinder. Steps come from a texture.
const TUBE = `
  uniform highp usampler2D steps; uniform mat4 part, view; uniform vec3 low, eye; uniform float unit, travelWidth;
  uniform vec2 sizes; uniform ivec2 layers; uniform int shown, base, stride;
  out vec3 across, toward; out float side, tint; flat out int id;
  uvec4 step_(int at) { return texelFetch(steps, ivec2(at & 2047, at >> 11), 0); }
  vec3 place(uvec4 s) { return (part * vec4(low + vec3(s.x & 65535u, s.x >> 16, s.y & 65535u) * unit, 1)).xyz; }
  void main() {
    // Every n-th step if frames take long.
    int segment = gl_VertexID / 6 * stride + base, corner = gl_VertexID % 6;
    corner = corner < 3 ? corner : corner == 3 ? 2 : corner == 4 ? 1 : 3;
    uvec4 from = step_(segment), s = step_(segment + stride);
    int kind = int(s.w & 255u), layer = int(s.y >> 16);
    bool travels = kind == 255;
    if (layer < layers.x || layer > layers.y || (shown >> min(kind, 15) & 1) == 0 || (stride > 1 && from.w >> 16 != s.w >> 16)) { gl_Position = vec4(2, 2, 2, 1); return; }
    vec2 f = vec2(s.z & 255u, s.z >> 8 & 255u) / 127.0 - 1.0;
    vec3 up = vec3(f, 1.0 - abs(f.x) - abs(f.y));
    float fold = max(-up.z, 0.0);
    up.xy += vec2(up.x < 0.0 ? fold : -fold, up.y < 0.0 ? fold : -fold);
    up = mat3(part) * normalize(up);
    vec2 half2 = travels ? vec2(travelWidth) : 0.5 * vec2(s.z >> 16 & 255u, s.z >> 24) * sizes;
    vec3 a = place(from), b = place(s);
    vec3 axis = b - a;
    float longs = length(axis);
    axis = longs > 1e-6 ? axis / longs : vec3(1, 0, 0);
    vec3 sink = travels ? vec3(0) : up * half2.y;
    float along = float(corner >> 1);
    side = float(corner & 1) * 2.0 - 1.0;
    vec3 p = mix(a, b, along) - sink;
    vec3 sight = normalize(eye - p), flank = cross(axis, up);
    flank = length(flank) > 1e-4 ? normalize(flank) : vec3(0, 1, 0);
    vec3 rise = cross(flank, axis);
    across = cross(axis, sight);
    across = length(across) > 1e-4 ? normalize(across) : flank;
    toward = normalize(cross(across, axis));
    toward *= dot(toward, sight) < 0.0 ? -1.0 : 1.0;
    float r = length(vec2(dot(across, flank), dot(across, rise)) * half2);
    p += across * (side * r) + axis * ((along * 2.0 - 1.0) * r * 0.35);
    tint = float(s.w >> 8 & 255u); id = segment + 1;
    gl_Position = view * vec4(p, 1);
  }`;
const LIGHT = `
  float light(vec3 n, vec3 sight) {
    return 0.35 + 0.45 * max(dot(n, normalize(vec3(0.35, -0.5, 0.8))), 0.0) + 0.3 * max(dot(n, sight), 0.0);
  }`;
const tube = program(TUBE, `
  in vec3 across, toward; in float side, tint; flat in int id; uniform sampler2D palette; uniform int picking; out vec4 colour;` + LIGHT + `
  void main() {
    if (picking == 1) { colour = vec4(id & 255, id >> 8 & 255, id >> 16 & 255, id >> 24 & 255) / 255.0; return; }
    float s = clamp(side, -0.98, 0.98);
    vec3 n = normalize(across * s + toward * sqrt(1.0 - s * s));
    colour = vec4(texture(palette, vec2((tint + 0.5) / 256.0, 0.5)).rgb * light(n, toward), 1);
  }`);
const solid = program(`
  layout(location = 0) in vec3 place; uniform mat4 frame, view; uniform vec3 low, from; uniform float unit, dot_, raise; out vec3 at;
  void main() { at = (frame * vec4(low + place * unit, 1)).xyz; gl_Position = view * vec4(at + (raise > 0.0 ? normalize(from - at) * raise : vec3(0)), 1); gl_PointSize = dot_; }`, `
  in vec3 at; uniform vec4 tone; uniform vec3 eye; uniform int flat_; out vec4 colour;` + LIGHT + `
  void main() {
    if (flat_ == 2 && length(gl_PointCoord - 0.5) > 0.5) discard;
    vec3 sight = normalize(eye - at), n = cross(dFdx(at), dFdy(at));
    n = normalize(n) * (dot(n, sight) < 0.0 ? -1.0 : 1.0);
    colour = vec4(tone.rgb * (flat_ > 0 ? 1.0 : light(n, sight)), tone.a);
  }`);

// ---- what is drawn
const buffer = (data, kind = gl.ARRAY_BUFFER) => {
  const made = gl.createBuffer();
  gl.bindBuffer(kind, made);
  gl.bufferData(kind, data, gl.STATIC_DRAW);
  return made;
};
// A mesh of whole numbers of units, or of floats.
function mesh(points, corners) {
  const array = gl.createVertexArray(), whole = points instanceof Uint16Array;
  gl.bindVertexArray(array);
  buffer(points);
  gl.enableVertexAttribArray(0);
  gl.vertexAttribPointer(0, 3, whole ? gl.UNSIGNED_SHORT : gl.FLOAT, false, whole ? 8 : 12, 0);
  if (corners) buffer(corners, gl.ELEMENT_ARRAY_BUFFER);
  gl.bindVertexArray(null);
  return { array, count: corners ? corners.length : points.length / (whole ? 4 : 3), whole };
}
const woven = (columns, name) => {
  const x = columns[name + '.x'], y = columns[name + '.y'], z = columns[name + '.z'], out = new Uint16Array(4 * x.length);
  for (let i = 0; i < x.length; i++) { out[4 * i] = x[i]; out[4 * i + 1] = y[i]; out[4 * i + 2] = z[i]; }
  return out;
};
// A solid of revolution about z through pairs of radius and height.
function revolved(profile, around = 32) {
  const points = [], corners = [];
  profile.forEach(([r, z], ring) => {
    for (let i = 0; i < around; i++) {
      const turn = 2 * Math.PI * i / around;
      points.push(r * Math.cos(turn), r * Math.sin(turn), z);
      const a = ring * around + i, b = ring * around + (i + 1) % around;
      if (ring + 1 < profile.length) corners.push(a, b, b + around, a, b + around, a + around);
    }
  });
  return mesh(new Float32Array(points), new Uint32Array(corners));
}

function start(columns) {
  const low = header.low, tick = header.tick, count = header.steps, layers = Math.max(header.layers, 1), robot = header.robot;
  const X = columns['step.x'], Y = columns['step.y'], Z = columns['step.z'], T = columns['step.t'], K = columns['step.kind'];
  const L = columns['step.layer'], P = columns['step.path'], U = columns['step.u'], V = columns['step.v'];
  const W = columns['step.w'], H = columns['step.h'];
  const tip = i => [low[0] + X[i] * header.unit, low[1] + Y[i] * header.unit, low[2] + Z[i] * header.unit];
  const direction = i => {
    const u = U[i] / 127 - 1, v = V[i] / 127 - 1, z = 1 - Math.abs(u) - Math.abs(v), fold = Math.max(-z, 0);
    return unit([u < 0 ? u + fold : u - fold, v < 0 ? v + fold : v - fold, z]);
  };
  const lengthTo = i => i ? Math.hypot(X[i] - X[i - 1], Y[i] - Y[i - 1], Z[i] - Z[i - 1]) * header.unit : 0;
  const secondsTo = i => (T[i] - (i ? T[i - 1] : 0)) * tick;
  const lays = i => K[i] !== 255;

  // Where layers and paths begin and end.
  const first = new Array(layers).fill(Infinity), last = new Array(layers).fill(-1), ofPath = new Map();
  const layerSeconds = new Float64Array(layers);
  for (let i = 0; i < count; i++) {
    const layer = L[i];
    first[layer] = Math.min(first[layer], i);
    last[layer] = i;
    layerSeconds[layer] += secondsTo(i);
    if (!lays(i)) continue;
    if (!ofPath.has(P[i])) ofPath.set(P[i], [i, i]);
    ofPath.get(P[i])[1] = i;
  }
  const clock = s => s < 60 ? s.toFixed(1) + ' s' : s < 3600 ? (s / 60).toFixed(1) + ' min' : Math.floor(s / 3600) + ' h ' + Math.round(s % 3600 / 60) + ' min';
  const total = count ? T[count - 1] * tick : 0;

  // ---- buffers
  // A texel for each step: x, y, z, layer; direction, width, height; kind, colour, path.
  const ROW = 2048, rows = Math.max(1, Math.ceil(count / ROW)), octets = new Uint8Array(16 * ROW * rows), words = new Uint16Array(octets.buffer);
  for (let i = 0; i < count; i++) {
    words.set([X[i], Y[i], Z[i], L[i]], 8 * i);
    octets.set([U[i], V[i], W[i], H[i], K[i]], 16 * i + 8);
    words[8 * i + 7] = P[i];
  }
  const [parts, mould, sheets, ends, marks] = ['part', 'mould', 'sheet', 'end', 'mark'].map(of => mesh(woven(columns, of), columns[of + '.corner']));
  const plate = mesh(new Float32Array(header.plate.flat()), null);
  const cylinder = revolved([[0, 0], [1, 0], [1, 1], [0, 1]], 20);
  const nozzle = header.nozzle && (([d, half, cone, block]) => {
    const wide = d / 2 + cone * Math.tan(half * Math.PI / 180);
    return revolved([[0, 0], [d / 2, 0], [wide, cone], [Math.max(block / 2, wide), cone], [Math.max(block / 2, wide), cone + 15], [0, cone + 15]]);
  })(header.nozzle);
  const [palette, steps] = [0, 1].map(unit => {
    const made = gl.createTexture();
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(gl.TEXTURE_2D, made);
    for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, name, gl.NEAREST);
    return gl.TEXTURE0 + unit;
  });
  const pickBuffer = gl.createFramebuffer(), pickColour = gl.createRenderbuffer(), pickDepth = gl.createRenderbuffer();
  gl.bindFramebuffer(gl.FRAMEBUFFER, pickBuffer);
  for (const [render, format, place] of [[pickColour, gl.RGBA8, gl.COLOR_ATTACHMENT0], [pickDepth, gl.DEPTH_COMPONENT24, gl.DEPTH_ATTACHMENT]]) {
    gl.bindRenderbuffer(gl.RENDERBUFFER, render);
    gl.renderbufferStorage(gl.RENDERBUFFER, format, 1, 1);
    gl.framebufferRenderbuffer(gl.FRAMEBUFFER, place, gl.RENDERBUFFER, render);
  }
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  const bare = gl.createVertexArray();

  const thick = robot && robot.stances ? 0.035 * Math.max(...robotAt(0).arm.map(([a, b]) => Math.hypot(...sub(a, b)))) : 0;

  // ---- state
  const extent = Math.hypot(...sub(header.high, header.low)) || 1, { middle, around } = header;
  // The camera goes with the part.
  const camera = { yaw: -0.9, pitch: 0.5, far: 2.1 * around, target: middle, carried: middle };
  const state = { low: 0, high: layers - 1, now: total, playing: false, colour: count ? 'kind' : 'layer', selected: -1, drawn: 0, frames: 0, frameMs: 0, errors: 0 };
  const shown = {};
  let dirty = true;
  const touch = () => { dirty = true; };

  // ---- colours
  const KINDS = ['#5b8fb9', '#2f9e8f', '#b8a642', '#7d8f3c', '#8c6d4f', '#8a8f98', '#6b9e2f', '#b9c7a0', '#3c3f46'];
  const rgb = hex => [1, 3, 5].map(at => parseInt(hex.slice(at, at + 2), 16));
  const ramp = t => {
    const steps = header.ramp, at = Math.min(Math.max(t, 0), 1) * (steps.length - 1), i = Math.min(Math.floor(at), steps.length - 2);
    return steps[i].map((c, axis) => c + (steps[i + 1][axis] - c) * (at - i));
  };
  const jointAt = joint => i => robotValue(stanceAt(T[i]), 'q' + joint, 30000) * 180 / Math.PI;
  const curvature = i => {
    if (i < 2 || !lays(i - 1) || P[i] !== P[i - 1]) return 0;
    const a = sub(tip(i - 1), tip(i - 2)), b = sub(tip(i), tip(i - 1)), mean = (Math.hypot(...a) + Math.hypot(...b)) / 2;
    return mean > 1e-6 ? Math.acos(Math.min(Math.max(dot(unit(a), unit(b)), -1), 1)) / mean : 0;
  };
  const COLOURS = {
    kind: { name: 'kind of bead' },
    layer: { name: 'layer', unit: '', of: i => L[i] + 1 },
    time: { name: 'time', unit: ' min', of: i => T[i] * tick / 60 },
    height: { name: 'height (spacing of layers)', unit: ' mm', of: i => H[i] * header.height },
    width: { name: 'width', unit: ' mm', of: i => W[i] * header.width },
    tilt: { name: 'tilt of the nozzle', unit: ' deg', of: i => Math.acos(direction(i)[2]) * 180 / Math.PI },
    speed: { name: 'speed', unit: ' mm/s', of: i => secondsTo(i) ? lengthTo(i) / secondsTo(i) : 0 },
    curvature: { name: 'curvature of the path', unit: ' 1/mm', of: curvature },
  };
  if (robot) for (let joint = 0; joint < robot.joints; joint++) COLOURS['joint' + joint] = { name: 'joint ' + (joint + 1), unit: ' deg', of: jointAt(joint) };
  function paint() {
    const colour = COLOURS[state.colour], paintStep = (i, at) => { octets[16 * i + 13] = at; }, texels = new Uint8Array(4 * 256), legend = find('legend');
    const texel = (at, c) => texels.set([...c.map(Math.round), 255], 4 * at);
    legend.textContent = '';
    if (!count) return touch();
    if (colour.of) {
      const numbers = new Float32Array(count), sample = [];
      for (let i = 0; i < count; i++) if (lays(i)) { numbers[i] = colour.of(i); if (i % (1 + (count >> 14)) === 0) sample.push(numbers[i]); }
      sample.sort((a, b) => a - b);
      // Without outliers.
      const cut = Math.floor(sample.length * (['layer', 'time'].includes(state.colour) ? 0 : 0.01));
      const least = sample.length ? sample[cut] : 0, most = sample.length ? sample[sample.length - 1 - cut] : 1;
      for (let i = 0; i < count; i++) paintStep(i, lays(i) ? 254 * Math.min(Math.max((numbers[i] - least) / (most - least || 1), 0), 1) : 255);
      for (let at = 0; at < 255; at++) texel(at, ramp(at / 254));
      const bar = make(legend, 'b'), ends = make(legend, 'span');
      bar.style.background = `linear-gradient(90deg, ${[0, 0.25, 0.5, 0.75, 1].map(t => `rgb(${ramp(t).map(Math.round)})`)})`;
      for (const value of [least, most]) make(ends, 'span').textContent = Number(value.toPrecision(3)) + colour.unit;
      legend.append(colour.name);
    } else {
      for (let i = 0; i < count; i++) paintStep(i, K[i]);
      KINDS.forEach((hex, at) => texel(at, rgb(hex)));
      header.kinds.forEach((kind, at) => {
        if (!used.has(at)) return;
        make(legend, 'i').style.background = KINDS[at];
        legend.append(kind);
      });
    }
    texel(255, [150, 155, 165]);
    gl.activeTexture(palette);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, 256, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, texels);
    gl.activeTexture(steps);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32UI, ROW, rows, 0, gl.RGBA_INTEGER, gl.UNSIGNED_INT, new Uint32Array(octets.buffer));
    touch();
  }
  const used = new Set(K);

  // ---- time
  function upTo(numbers, value) {
    let low = 0, high = numbers.length;
    while (low < high) { const at = low + high >> 1; if (numbers[at] <= value) low = at + 1; else high = at; }
    return low;
  }
  const spanOf = layer => last[layer] < 0 ? [0, 0] : [first[layer] ? T[first[layer] - 1] * tick : 0, T[last[layer]] * tick];
  const doneAt = seconds => upTo(T, seconds / tick + 0.5);
  function stanceAt(ticks) {
    const times = columns['robot.t'], b = Math.min(Math.max(upTo(times, ticks), 1), times.length - 1), a = Math.max(b - 1, 0);
    return [a, b, times[b] > times[a] ? Math.min(Math.max((ticks - times[a]) / (times[b] - times[a]), 0), 1) : 0];
  }
  function robotValue([a, b, s], name, scale) {
    const column = columns['robot.' + name];
    return ((column[a] | 0) * (1 - s) + (column[b] | 0) * s) / scale;
  }
  function robotAt(seconds) {
    const at = stanceAt(seconds / tick), of = (name, scale) => robotValue(at, name, scale);
    const arm = Array.from({ length: robot.bones }, (_, bone) => [0, 1].map(end => [0, 1, 2].map(axis => of(`a${bone}.${end}.${axis}`, 100))));
    const turn = [0, 1, 2, 3].map(axis => of('r' + axis, 30000)), size = Math.hypot(...turn) || 1;
    return { arm, part: turned(turn.map(c => c / size), [0, 1, 2].map(axis => of('p' + axis, 100))) };
  }
  function nozzleAt(seconds) {
    const done = doneAt(seconds), b = Math.min(done, count - 1), a = Math.max(b - 1, 0), span = (T[b] - T[a]) * tick;
    const s = span > 0 ? Math.min(Math.max((seconds - T[a] * tick) / span, 0), 1) : 1;
    return [add(tip(a), sub(tip(b), tip(a)), s), unit(add(direction(a), sub(direction(b), direction(a)), s))];
  }

  // ---- drawing
  function matrices(pick) {
    const { width, height } = canvas, near = Math.max(camera.far / 100, 0.05), far = camera.far + 20 * extent + (robot ? 8000 : 0), f = 1 / Math.tan(0.3);
    const toward = [Math.cos(camera.pitch) * Math.cos(camera.yaw), Math.cos(camera.pitch) * Math.sin(camera.yaw), Math.sin(camera.pitch)];
    const eye = add(camera.target, toward, camera.far), x = [-Math.sin(camera.yaw), Math.cos(camera.yaw), 0], y = cross(toward, x);
    const look = [x[0], y[0], toward[0], 0, x[1], y[1], toward[1], 0, x[2], y[2], toward[2], 0, -dot(x, eye), -dot(y, eye), -dot(toward, eye), 1];
    let view = times([f * height / width, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / (near - far), -1, 0, 0, 2 * far * near / (near - far), 0], look);
    if (pick) view = times([width, 0, 0, 0, 0, height, 0, 0, 0, 0, 1, 0, -pick[0] * width, -pick[1] * height, 0, 1], view);
    return { view, eye, x, y, toward };
  }
  function setUp(which, view, eye) {
    gl.useProgram(which.made);
    gl.uniformMatrix4fv(which.places.view, false, view);
    gl.uniform3fv(which.places.eye, eye);
    if (which.places.from) gl.uniform3fv(which.places.from, eye);
  }
  function drawMesh(what, matrix, tone, mode = gl.TRIANGLES, from = 0, many = what.count, flat = 0, dots = 1) {
    if (!many) return;
    gl.uniformMatrix4fv(solid.places.frame, false, matrix);
    gl.uniform3fv(solid.places.low, what.whole ? low : [0, 0, 0]);
    gl.uniform1f(solid.places.unit, what.whole ? header.unit : 1);
    gl.uniform1f(solid.places.dot_, dots);
    gl.uniform4fv(solid.places.tone, tone);
    gl.uniform1i(solid.places.flat_, flat);
    gl.bindVertexArray(what.array);
    if (mode === gl.TRIANGLES) gl.drawElements(mode, many, gl.UNSIGNED_INT, 4 * from);
    else gl.drawArrays(mode, from, many);
  }
  function drawTubes(part, view, eye, picking) {
    let from = Infinity, to = -1;
    for (let layer = state.low; layer <= state.high; layer++) { from = Math.min(from, first[layer]); to = Math.max(to, last[layer]); }
    from = Math.max(Math.min(from, count) - 1, 0);
    const many = Math.min(to + 1, doneAt(state.now)) - 1 - from;
    state.drawn = Math.max(many, 0);
    if (many <= 0) return;
    let mask = shown.travels ? 1 << 15 : 0;
    header.kinds.forEach((_, at) => { if (shown['kind' + at] && shown.paths) mask |= 1 << at; });
    setUp(tube, view, eye);
    const { places } = tube;
    gl.uniformMatrix4fv(places.part, false, part);
    gl.uniform3fv(places.low, low);
    gl.uniform1f(places.unit, header.unit);
    gl.uniform2f(places.sizes, header.width, header.height);
    gl.uniform2i(places.layers, state.low, state.high);
    gl.uniform1i(places.steps, 1);
    gl.uniform1f(places.travelWidth, 0.0006 * camera.far);
    gl.uniform1i(places.shown, mask);
    const step = picking ? 1 : stride;
    gl.uniform1i(places.base, from);
    gl.uniform1i(places.stride, step);
    gl.uniform1i(places.picking, picking ? 1 : 0);
    gl.bindVertexArray(bare);
    gl.drawArrays(gl.TRIANGLES, 0, 6 * Math.max(Math.floor(many / step), 1));
  }
  const layerTone = layer => [...ramp(layers > 1 ? layer / (layers - 1) : 0).map(c => c / 255 * (layer % 2 ? 0.88 : 1)), 1];
  let scale = 1, stride = 1, settled = 0;
  function draw() {
    const wide = Math.max(1, Math.round(canvas.clientWidth * devicePixelRatio * scale)), tall = Math.max(1, Math.round(canvas.clientHeight * devicePixelRatio * scale));
    if (canvas.width !== wide || canvas.height !== tall) { canvas.width = wide; canvas.height = tall; }
    const stance = robot && shown.robot ? robotAt(state.now) : null, part = stance ? stance.part : IDENTITY, carried = moved(part, middle);
    camera.target = add(camera.target, sub(carried, camera.carried));
    camera.carried = carried;
    const { view, eye } = matrices();
    const paper = getComputedStyle(section).backgroundColor.match(/[\d.]+/g).map(c => c / 255), dark = paper[0] < 0.5;
    gl.viewport(0, 0, wide, tall);
    gl.clearColor(paper[0], paper[1], paper[2], 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    setUp(solid, view, eye);
    const grey = dark ? [0.25, 0.28, 0.32, 1] : [0.86, 0.88, 0.91, 1];
    if (shown.plate) drawMesh(plate, times(part, frame([0, 0, -0.02], [0, 0, 1])), grey, gl.TRIANGLE_FAN, 0, plate.count, 1);
    if (shown.mould) drawMesh(mould, part, grey);
    if (shown.sheets) {
      const starts = columns['sheet.first'];
      for (let layer = state.low; layer <= state.high && layer + 1 < starts.length; layer++) {
        if (layer < state.high || !count || state.now >= spanOf(layer)[1]) drawMesh(sheets, part, layerTone(layer), gl.TRIANGLES, starts[layer], starts[layer + 1] - starts[layer]);
      }
    }
    if (count > 1 && (shown.paths || shown.travels)) drawTubes(part, view, eye, false);
    setUp(solid, view, eye);
    if (shown.nozzle && count && nozzle) {
      const [at, up] = nozzleAt(state.now);
      drawMesh(nozzle, times(part, frame(at, up)), [0.72, 0.55, 0.25, 1]);
    }
    if (stance) stance.arm.forEach(([from, to]) => {
      const bone = sub(to, from), long = Math.hypot(...bone);
      if (long > 1e-3) drawMesh(cylinder, frame(from, unit(bone), thick, long), dark ? [0.55, 0.6, 0.68, 1] : [0.45, 0.5, 0.58, 1]);
    });
    if (shown.ends) {
      columns['end.layer'].forEach((layer, i) => {
        if (layer >= state.low && layer <= state.high) drawMesh(ends, part, [0.85, 0.2, 0.15, 1], gl.LINES, 2 * i, 2, 1);
      });
    }
    // Opaque with nothing inside.
    if (shown.part && !count && !sheets.count) drawMesh(parts, part, [0.45, 0.6, 0.75, 1]);
    // Marks hide with their layers.
    let from = 0;
    gl.uniform1f(solid.places.raise, 1.5 * Math.max(header.width * 127, 1));
    header.marks.forEach(([, colour, many], at) => {
      const end = from + many;
      while (shown['mark' + at] && from < end) {
        const begin = from, visible = markShows(from);
        while (from < end && markShows(from) === visible) from++;
        if (visible) drawMesh(marks, part, [...colour.map(c => c / 255), 0.9], gl.POINTS, begin, from - begin, 2, 7 * devicePixelRatio * scale);
      }
      from = end;
    });
    gl.uniform1f(solid.places.raise, 0);
    gl.disable(gl.DEPTH_TEST);
    if (state.selected >= 0 || spot) {
      const at = spot || tip(state.selected);
      drawMesh(pin, times(part, [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, ...at, 1]), [1, 0.85, 0, 1], gl.POINTS, 0, 1, 2, 11 * devicePixelRatio * scale);
    }
    gl.enable(gl.DEPTH_TEST);
    if (shown.part && (count || sheets.count)) {
      gl.enable(gl.BLEND);
      gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
      gl.depthMask(false);
      drawMesh(parts, part, dark ? [0.7, 0.76, 0.84, 0.22] : [0.35, 0.42, 0.52, 0.2]);
      gl.depthMask(true);
      gl.disable(gl.BLEND);
    }
    if (gl.getError()) state.errors++;
  }
  const markLayer = Array.from(columns['mark.path'], path => ofPath.has(path) ? L[ofPath.get(path)[0]] : -1);
  const markShows = mark => markLayer[mark] < 0 || markLayer[mark] >= state.low && markLayer[mark] <= state.high;
  const pin = mesh(new Float32Array([0, 0, 0]));
  let spot = null;
  function pick(x, y) {
    const box = canvas.getBoundingClientRect(), at = [2 * (x - box.left) / box.width - 1, 1 - 2 * (y - box.top) / box.height];
    const { view, eye } = matrices(at), part = robot && shown.robot ? robotAt(state.now).part : IDENTITY;
    gl.bindFramebuffer(gl.FRAMEBUFFER, pickBuffer);
    gl.viewport(0, 0, 1, 1);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    if (count > 1) drawTubes(part, view, eye, true);
    const texel = new Uint8Array(4);
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, texel);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    const id = texel[0] | texel[1] << 8 | texel[2] << 16 | texel[3] << 24;
    select(id ? id : -1);
  }
  function select(step) {
    state.selected = step < count ? step : -1;
    spot = null;
    const info = find('info');
    info.hidden = state.selected < 0;
    if (state.selected >= 0) {
      const [at, up, i] = [tip(step), direction(step), step], span = ofPath.get(P[i]);
      info.textContent = [`layer ${L[i] + 1}, path ${P[i]}${span && lays(i) ? `, waypoint ${i - span[0] + 1}` : ''}`, lays(i) ? header.kinds[K[i]] : 'travel',
        `tip ${at.map(c => c.toFixed(2)).join(', ')} mm`, `direction ${up.map(c => c.toFixed(2)).join(', ')}`,
        lays(i) ? `bead ${(W[i] * header.width).toFixed(2)} x ${(H[i] * header.height).toFixed(2)} mm` : '',
        `at ${clock(T[i] * tick)}${secondsTo(i) ? `, ${(lengthTo(i) / secondsTo(i)).toFixed(1)} mm/s` : ''}`].filter(Boolean).join('\n');
    }
    touch();
  }

  // ---- controls
  const [lowInput, highInput, nowInput] = ['low', 'high', 'now'].map(find), run = find('run');
  const show = (input, text) => { input.parentNode.querySelector('output').textContent = text; };
  function showTime() {
    lowInput.value = state.low + 1;
    highInput.value = state.high + 1;
    const [from, to] = spanOf(state.high);
    nowInput.value = to > from ? Math.round(1000 * Math.min(Math.max((state.now - from) / (to - from), 0), 1)) : 1000;
    show(lowInput, `${state.low + 1} of ${layers}`);
    show(highInput, `${state.high + 1} of ${layers}`);
    show(nowInput, clock(state.now));
    plotJoints();
    touch();
  }
  function toLayer(layer, whole = true) {
    state.high = Math.min(Math.max(layer, 0), layers - 1);
    state.low = Math.min(state.low, state.high);
    state.now = spanOf(state.high)[whole ? 1 : 0];
    showTime();
  }
  lowInput.max = highInput.max = layers;
  lowInput.oninput = () => { state.low = lowInput.value - 1; if (state.low > state.high) toLayer(state.low); else showTime(); };
  highInput.oninput = () => toLayer(highInput.value - 1);
  nowInput.oninput = () => { const [from, to] = spanOf(state.high); state.now = from + (to - from) * nowInput.value / 1000; showTime(); };
  function play(on) {
    state.playing = on && count > 1;
    run.textContent = state.playing ? 'Pause' : 'Play';
    if (state.playing && state.now >= total) { state.low = 0; toLayer(0, false); }
    touch();
  }
  run.onclick = () => play(!state.playing);
  function advance(seconds) {
    state.now = Math.min(state.now + seconds * find('speed').value, total);
    const done = Math.min(doneAt(state.now), count - 1);
    state.high = L[done];
    state.low = Math.min(state.low, state.high);
    if (state.now >= total) play(false);
    showTime();
  }
  const VIEWS = { Home: [-0.9, 0.5], Front: [-Math.PI / 2, 0], Left: [Math.PI, 0], Right: [0, 0], Back: [Math.PI / 2, 0], Top: [-Math.PI / 2, 1.5607], Bottom: [-Math.PI / 2, -1.5607] };
  // Looks at a place, wherever the robot has it.
  function aim(place) {
    const part = robot && shown.robot ? robotAt(state.now).part : IDENTITY;
    camera.target = moved(part, place);
    camera.carried = moved(part, middle);
  }
  function see(name) {
    [camera.yaw, camera.pitch] = VIEWS[name];
    camera.far = 2.1 * around;
    aim(middle);
    if (robot && shown.robot && !header.built) {
      const all = [...robotAt(state.now).arm.flat(), camera.target];
      const [least, most] = [Math.min, Math.max].map(of => [0, 1, 2].map(axis => of(...all.map(p => p[axis]))));
      camera.target = add(least, sub(most, least), 0.5);
      camera.far = 2.2 * Math.max(Math.hypot(...sub(most, least)), around);
    }
    touch();
  }
  for (const name of Object.keys(VIEWS)) {
    const button = make(find('views'), 'button');
    button.type = 'button';
    button.textContent = name;
    button.onclick = () => see(name);
  }
  function toggle(parent, name, text, on, colour) {
    shown[name] = on;
    const label = make(parent, 'label'), box = make(label, 'input');
    box.type = 'checkbox';
    box.checked = on;
    box.onchange = () => { shown[name] = box.checked; if (name === 'robot') see('Home'); touch(); };
    if (colour) make(label, 'i').style.background = colour;
    label.append(' ' + text);
    return label;
  }
  const list = find('shown');
  if (parts.count) toggle(list, 'part', 'part', !count);
  if (header.plate.length) toggle(list, 'plate', 'plate', true);
  if (mould.count) toggle(list, 'mould', 'mould', true);
  if (sheets.count) toggle(list, 'sheets', 'surfaces of layers', !count);
  if (count > 1) {
    toggle(list, 'paths', 'beads', true);
    if (header.kinds.filter((_, at) => used.has(at)).length > 1) header.kinds.forEach((kind, at) => { if (used.has(at)) toggle(list, 'kind' + at, kind, true); });
    else header.kinds.forEach((_, at) => { shown['kind' + at] = true; });
    toggle(list, 'travels', 'travels', false);
    if (nozzle) toggle(list, 'nozzle', 'nozzle', true);
  }
  if (ends.count) toggle(list, 'ends', 'where surfaces end inside', false);
  if (robot) toggle(list, 'robot', robot.name, robot.shown);
  let from = 0;
  header.marks.forEach(([what, colour, many], at) => {
    const begin = from, finds = find('finds');
    from += many;
    finds.hidden = false;
    const label = toggle(finds, 'mark' + at, `${what} (${many})`, many <= 2000 || !count, `rgb(${colour})`);
    let current = -1;
    for (const [text, step] of [['‹', -1], ['›', 1]]) {
      const button = make(label, 'button');
      button.type = 'button';
      button.textContent = text;
      button.ariaLabel = step > 0 ? 'next place' : 'place before';
      button.onclick = event => { event.preventDefault(); current = (current + step + many) % many; toMark(begin + current); };
    }
  });
  function toMark(at) {
    const path = columns['mark.path'][at], span = ofPath.get(path);
    const place = [columns['mark.x'][at], columns['mark.y'][at], columns['mark.z'][at]].map((c, axis) => low[axis] + c * header.unit);
    if (span) {
      let nearest = span[0];
      for (let i = span[0]; i <= span[1]; i++) if (Math.hypot(...sub(tip(i), place)) < Math.hypot(...sub(tip(nearest), place))) nearest = i;
      toLayer(L[nearest]);
      state.now = T[nearest] * tick;
      showTime();
      select(nearest);
    } else { select(-1); }
    spot = place;
    aim(place);
    camera.far = Math.min(camera.far, 0.6 * around);
    touch();
  }
  const colourInput = find('colour');
  for (const [name, { name: text }] of Object.entries(COLOURS)) {
    if (!count && name !== 'layer') continue;
    const option = make(colourInput, 'option');
    option.value = name;
    option.textContent = text;
  }
  colourInput.value = state.colour;
  colourInput.onchange = () => { state.colour = colourInput.value; paint(); };
  lowInput.parentNode.hidden = highInput.parentNode.hidden = layers < 2;
  find('time').hidden = layers < 2 && !count;
  find('row').hidden = !count;
  find('sums').textContent = count ? [`${clock(total)} in all`, `${header.metres.toFixed(1)} m`, ...(layers > 1 ? [`${header.volume.toFixed(2)} cm3`] : []),
    ...(header.density ? [`${(header.volume * header.density).toFixed(1)} g`] : []), `${ofPath.size} starts`].join(' · ') : `${layers} layers`;

  // ---- input
  const pointers = new Map();
  let travelled = 0;
  function orbit(dx, dy) { camera.yaw -= 0.008 * dx; camera.pitch = Math.min(Math.max(camera.pitch + 0.008 * dy, -1.5607), 1.5607); touch(); }
  function pan(dx, dy) {
    const { x, y } = matrices(), mm = 2 * Math.tan(0.3) * camera.far / canvas.clientHeight;
    camera.target = add(add(camera.target, x, -dx * mm), y, dy * mm);
    touch();
  }
  function zoom(by) { camera.far = Math.min(Math.max(camera.far * by, around / 500), 60 * extent); touch(); }
  canvas.onpointerdown = event => { canvas.setPointerCapture(event.pointerId); pointers.set(event.pointerId, [event.clientX, event.clientY]); travelled = pointers.size > 1 ? 99 : 0; };
  canvas.onpointermove = event => {
    const before = pointers.get(event.pointerId);
    if (!before) return;
    const dx = event.clientX - before[0], dy = event.clientY - before[1];
    travelled += Math.abs(dx) + Math.abs(dy);
    if (pointers.size === 2) {
      const [, other] = [...pointers].find(([id]) => id !== event.pointerId), far = (x, y) => Math.hypot(x - other[0], y - other[1]) || 1;
      zoom(far(...before) / far(event.clientX, event.clientY));
      pan(dx / 2, dy / 2);
    } else if (event.shiftKey || event.buttons & 6) pan(dx, dy);
    else orbit(dx, dy);
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
  };
  canvas.onpointerup = event => { pointers.delete(event.pointerId); if (travelled < 5 && event.button === 0) pick(event.clientX, event.clientY); };
  canvas.onpointercancel = event => pointers.delete(event.pointerId);
  canvas.oncontextmenu = event => event.preventDefault();
  canvas.ondblclick = () => { if (state.selected >= 0) { aim(tip(state.selected)); touch(); } };
  canvas.addEventListener('wheel', event => { event.preventDefault(); zoom(Math.exp(0.0012 * event.deltaY * (event.deltaMode ? 20 : 1))); }, { passive: false });
  const KEYS = { ArrowLeft: () => orbit(-20, 0), ArrowRight: () => orbit(20, 0), ArrowUp: () => orbit(0, 20), ArrowDown: () => orbit(0, -20), '+': () => zoom(0.85), '-': () => zoom(1.18),
    Home: () => see('Home'), ' ': () => play(!state.playing), PageUp: () => toLayer(state.high + 1), PageDown: () => toLayer(state.high - 1), Escape: () => select(-1) };
  canvas.onkeydown = event => { if (KEYS[event.key]) { event.preventDefault(); KEYS[event.key](); } };
  new ResizeObserver(touch).observe(canvas);
  matchMedia('(prefers-color-scheme: dark)').onchange = touch;

  // ---- plots: time by layer; speeds of joints
  const svg = (name, attributes, parent) => {
    const made = parent.appendChild(document.createElementNS('http://www.w3.org/2000/svg', name));
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    return made;
  };
  const WIDE = 1000, TALL = 100;
  const chart = title => {
    make(find('plots'), 'p').textContent = title;
    return svg('svg', { viewBox: `0 0 ${WIDE} ${TALL}`, preserveAspectRatio: 'none', role: 'img', 'aria-label': title }, find('plots'));
  };
  if (count && layers > 1) {
    const most = layerSeconds.reduce((a, b) => Math.max(a, b)), plot = chart(`time of each layer, ${clock(most)} at most`);
    layerSeconds.forEach((seconds, layer) => {
      const tall = TALL * seconds / (most || 1), bar = svg('rect', { x: WIDE * layer / layers, y: TALL - tall, width: 0.85 * WIDE / layers, height: tall }, plot);
      svg('title', {}, bar).textContent = `layer ${layer + 1}: ${clock(seconds)}`;
      bar.onclick = () => toLayer(layer);
    });
  }
  const joints = robot && robot.joints && robot.stances > 1 ? chart('speed of each joint; the top line is its limit') : null;
  function plotJoints() {
    if (!joints) return;
    const [from, to] = spanOf(state.high), times = columns['robot.t'], a = Math.max(upTo(times, from / tick) - 1, 0), b = Math.min(upTo(times, to / tick), times.length - 1);
    joints.textContent = '';
    const x = ticks => WIDE * (ticks * tick - from) / (to - from || 1);
    svg('path', { d: `M0 2H${WIDE}`, stroke: 'currentColor', opacity: 0.3, 'vector-effect': 'non-scaling-stroke' }, joints);
    for (let joint = 0; joint < robot.joints; joint++) {
      const q = columns['robot.q' + joint], stride = Math.max(1, Math.floor((b - a) / 600));
      let line = '';
      for (let i = a; i + stride <= b; i += stride) {
        const speed = Math.abs((q[i + stride] | 0) - (q[i] | 0)) / 30000 / ((times[i + stride] - times[i]) * tick || 1) / robot.speeds[joint];
        line += `${line ? 'L' : 'M'}${x((times[i] + times[i + stride]) / 2).toFixed(1)} ${(TALL - (TALL - 2) * speed).toFixed(1)}`;
      }
      const made = svg('path', { d: line || 'M0 0', fill: 'none', stroke: KINDS[joint % KINDS.length], 'vector-effect': 'non-scaling-stroke' }, joints);
      svg('title', {}, made).textContent = 'joint ' + (joint + 1);
    }
    svg('path', { d: `M${x(state.now / tick).toFixed(1)} 0V${TALL}`, stroke: 'currentColor', 'vector-effect': 'non-scaling-stroke' }, joints);
  }

  // ---- frames: when something has changed; coarser while they take long
  let before = performance.now();
  function frameOf(now) {
    const passed = Math.min((now - before) / 1000, 0.25);
    before = now;
    if (state.playing) advance(passed);
    if (dirty) {
      dirty = false;
      const begun = performance.now();
      draw();
      gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4)); // waits for it
      state.frameMs = performance.now() - begun;
      state.frames++;
      if (state.frameMs > 60) [scale, stride] = [Math.max(0.4, 0.8 * scale), Math.min(16, 2 * stride)];
      settled = now;
    } else if (stride > 1 && now - settled > 400) { scale = stride = 1; draw(); }
    requestAnimationFrame(frameOf);
  }
  find('busy').hidden = true;
  see('Home');
  paint();
  showTime();
  requestAnimationFrame(frameOf);
  section.viewer = { state, camera, shown, header, select, toLayer, toMark, play, see, pick, nozzleAt, touch };
}
unpack().then(start).catch(error => {
  const busy = find('busy');
  busy.hidden = false;
  busy.textContent = 'the build cannot be shown: ' + error.message;
  console.error(error);
});
})(document.currentScript.closest('section'));
