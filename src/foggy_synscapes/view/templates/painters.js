// Two ways of painting fog on a canvas: by WebGL 2, and by the processor where there is no WebGL. Both give the same
// levels but where a value lies on the edge between two.

import { transmittance } from "./optics.js";

export const FOG = 0;
export const TRANSMITTANCE = 1;

const VERTICES = `#version 300 es
void main() { // one triangle that covers the image
  gl_Position = vec4(vec2(gl_VertexID == 1, gl_VertexID == 2) * 4.0 - 1.0, 0.0, 1.0);
}`;

const FRAGMENTS = `#version 300 es
precision highp float;
precision highp int;
precision highp sampler2D;
uniform sampler2D clear, metres;
uniform vec3 light;
uniform float beta;
uniform int shown, height;
out vec4 colour;
void main() {
  ivec2 at = ivec2(int(gl_FragCoord.x), height - 1 - int(gl_FragCoord.y));
  float t = exp(-min(beta * texelFetch(metres, at, 0).r, 100.0));
  vec3 levels = floor(texelFetch(clear, at, 0).rgb * 255.0 + 0.5);
  vec3 foggy = shown == ${TRANSMITTANCE} ? vec3(255.0 * t) : light + (levels - light) * t;
  colour = vec4(floor(foggy + 0.5) / 255.0, 1.0);
}`;

// frame : {width, height, clear: bytes of RGB, codes: of distance, table: metres by code}
export function gpuPainter(canvas, frame) {
  const options = { alpha: false, antialias: false, depth: false, preserveDrawingBuffer: true };
  const gl = canvas.getContext("webgl2", options);
  if (!gl) return null;
  if (Math.max(frame.width, frame.height) > gl.getParameter(gl.MAX_TEXTURE_SIZE)) return null;
  const program = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, VERTICES], [gl.FRAGMENT_SHADER, FRAGMENTS]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) return null;
  gl.useProgram(program);
  const metres = new Float32Array(frame.codes.length);
  // Shaders need not know infinity: 1e30 m are as far at every density that a person can set.
  for (let n = 0; n < metres.length; n++) metres[n] = Math.min(frame.table[frame.codes[n]], 1e30);
  gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
  texture(gl, 0, gl.RGB8, gl.RGB, gl.UNSIGNED_BYTE, frame, frame.clear);
  texture(gl, 1, gl.R32F, gl.RED, gl.FLOAT, frame, metres);
  const place = (name) => gl.getUniformLocation(program, name);
  gl.uniform1i(place("clear"), 0);
  gl.uniform1i(place("metres"), 1);
  gl.uniform1i(place("height"), frame.height);
  const light = place("light"), beta = place("beta"), shown = place("shown");
  return {
    name: "WebGL",
    paint(state) {
      if (gl.isContextLost()) return false;
      gl.viewport(0, 0, frame.width, frame.height);
      gl.uniform3f(light, ...state.light);
      gl.uniform1f(beta, state.beta);
      gl.uniform1i(shown, state.shown);
      gl.drawArrays(gl.TRIANGLES, 0, 3);
      return true;
    },
    // RGBA from the top row down
    pixels() {
      const line = 4 * frame.width;
      const upside = new Uint8Array(line * frame.height), found = new Uint8Array(upside.length);
      gl.readPixels(0, 0, frame.width, frame.height, gl.RGBA, gl.UNSIGNED_BYTE, upside);
      for (let y = 0; y < frame.height; y++) {
        found.set(upside.subarray((frame.height - 1 - y) * line, (frame.height - y) * line), y * line);
      }
      return found;
    },
  };
}

function texture(gl, unit, stored, format, type, frame, data) {
  gl.activeTexture(gl.TEXTURE0 + unit);
  gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
  for (const [name, value] of [
    [gl.TEXTURE_MIN_FILTER, gl.NEAREST],
    [gl.TEXTURE_MAG_FILTER, gl.NEAREST],
    [gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE],
    [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE],
  ]) gl.texParameteri(gl.TEXTURE_2D, name, value);
  gl.texImage2D(gl.TEXTURE_2D, 0, stored, frame.width, frame.height, 0, format, type, data);
}

export function plainPainter(canvas, frame) {
  const context = canvas.getContext("2d", { alpha: false });
  const image = context.createImageData(frame.width, frame.height);
  const out = new Uint32Array(image.data.buffer); // little-endian, as every machine with a browser is
  const through = new Float64Array(frame.table.length);
  return {
    name: "canvas",
    paint({ beta, light, shown }) {
      // Exponentials of 65,536 codes instead of a million pixels.
      for (let code = 0; code < through.length; code++) through[code] = transmittance(frame.table[code], beta);
      const { clear, codes } = frame;
      // Each level is floor(L + (R - L) t + 0.5), and never negative: | 0 is its floor.
      const [red, green, blue] = light.map((value) => value + 0.5);
      for (let n = 0, from = 0; n < out.length; n++, from += 3) {
        const t = through[codes[n]];
        if (shown === TRANSMITTANCE) {
          out[n] = 0xff000000 | (((255 * t + 0.5) | 0) * 0x010101);
        } else {
          out[n] =
            0xff000000 |
            ((red + (clear[from] - light[0]) * t) | 0) |
            (((green + (clear[from + 1] - light[1]) * t) | 0) << 8) |
            (((blue + (clear[from + 2] - light[2]) * t) | 0) << 16);
        }
      }
      context.putImageData(image, 0, 0);
      return true;
    },
    pixels: () => new Uint8Array(image.data),
  };
}

// Whether WebGL computes on a graphics processor: emulated, it is slower than the plain painter.
export function hasGraphics() {
  const gl = document.createElement("canvas").getContext("webgl2", { failIfMajorPerformanceCaveat: true });
  if (!gl) return false;
  const about = gl.getExtension("WEBGL_debug_renderer_info");
  const name = gl.getParameter(about ? about.UNMASKED_RENDERER_WEBGL : gl.RENDERER);
  gl.getExtension("WEBGL_lose_context")?.loseContext();
  return !/swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
}
