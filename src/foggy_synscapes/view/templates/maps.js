// Maps of trainIds as pictures.

export const IGNORE = 255;

const word = ([red, green, blue], alpha = 255) => ((alpha << 24) | (blue << 16) | (green << 8) | red) >>> 0;
const NOTHING = 0;

// maps : {truth, a, b}; trainIds by pixel, or null where a side is no map
// how : {shown, palette: RGB by class, right, wrong, only: one class or null, outlines}
// Returns 32-bit RGBA by pixel, of what lies over the image.
export function painted(side, maps, width, how) {
  const ids = maps[side], { truth } = maps;
  const found = new Uint32Array(truth.length);
  if (!ids) return found;
  if (how.shown === "errors" && ids !== truth) judge(found, ids, truth, null, how);
  else if (how.shown === "change" && maps.a && maps.b) judge(found, maps.b, truth, maps.a, how);
  else classes(found, ids, how);
  if (how.outlines) outline(found, ids, width);
  return found;
}

function classes(found, ids, { palette, only }) {
  const table = new Uint32Array(256).fill(word([0, 0, 0]));
  palette.forEach((colour, id) => (table[id] = word(colour)));
  if (only !== null) table.forEach((_, id) => (table[id] = id === only ? table[id] : NOTHING));
  for (let n = 0; n < ids.length; n++) found[n] = table[ids[n]];
}

// Where a prediction is wrong; beside an earlier one, where it became right or wrong.
function judge(found, ids, truth, before, { right, wrong, only }) {
  const good = word(right), bad = word(wrong);
  for (let n = 0; n < ids.length; n++) {
    const what = truth[n];
    if (what === IGNORE) continue;
    if (only !== null && what !== only && ids[n] !== only && before?.[n] !== only) continue;
    const hit = ids[n] === what;
    if (before === null) found[n] = hit ? NOTHING : bad;
    else if (hit !== (before[n] === what)) found[n] = hit ? good : bad;
  }
}

// White where a pixel's class differs from that on its left or above it, black beside it: seen on every colour.
function outline(found, ids, width) {
  const white = word([255, 255, 255]), black = word([0, 0, 0]);
  for (let n = width; n < ids.length; n++) {
    if (n % width && ids[n] !== ids[n - 1]) { found[n] = white; found[n - 1] = black; }
    if (ids[n] !== ids[n - width]) { found[n] = white; found[n - width] = black; }
  }
}
