// The formula of fog: F = t R + (1 - t) L with t = exp(-beta l), each level floor(255 F + 0.5).

export const AT_ZERO = 0;
export const INFINITE = 65535;
export const LIGHTEST = 1e-4; // 1/m, where the slider begins beside clear air
export const DENSEST = 0.3;

// Metres of each of the 65,536 codes of distance; see planes.py.
export function distanceTable(nearest, farthest) {
  const step = Math.log(farthest / nearest) / (INFINITE - 2);
  const table = new Float32Array(INFINITE + 1);
  for (let code = 1; code < INFINITE; code++) table[code] = nearest * Math.exp(step * (code - 1));
  table[AT_ZERO] = 0;
  table[INFINITE] = Infinity;
  return table;
}

export function transmittance(metres, beta) {
  return beta === 0 ? 1 : Math.exp(-beta * metres);
}

export function level(clear, light, t) {
  return Math.floor(light + (clear - light) * t + 0.5);
}

// Density on a slider from 0 to 1, logarithmic; 0 is clear air.
export function betaAt(position) {
  return position <= 0 ? 0 : LIGHTEST * (DENSEST / LIGHTEST) ** position;
}

export function positionOf(beta) {
  if (beta < LIGHTEST) return 0;
  return Math.min(1, Math.log(beta / LIGHTEST) / Math.log(DENSEST / LIGHTEST));
}
