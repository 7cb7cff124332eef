// Arrays that a page carries as text: what planes.py has written. No decoder of images is involved, because browsers
// may convert colours, or blur what is read back from a canvas to hinder the tracking of people.

export function blob(name) {
  const element = document.getElementById(`blob-${name}`);
  if (!element) throw new Error(`${name}: not in this page`);
  return element.textContent;
}

export function decoded(text) {
  const plain = atob(text);
  const bytes = new Uint8Array(plain.length);
  for (let n = 0; n < plain.length; n++) bytes[n] = plain.charCodeAt(n);
  return bytes;
}

async function inflated(text) {
  const stream = new Blob([decoded(text)]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// Bytes of an image, `line` of them in a row: each is the difference from the one above it.
export async function bytesOf(text, line) {
  const values = await inflated(text);
  for (let n = line; n < values.length; n++) values[n] += values[n - line];
  return values;
}

// 16-bit numbers, `line` of them in a row: high bytes, then low bytes, of folded differences from the one above.
export async function wordsOf(text, line) {
  const bytes = await inflated(text);
  const size = bytes.length / 2;
  const values = new Uint16Array(size);
  for (let n = 0; n < size; n++) {
    const folded = (bytes[n] << 8) | bytes[size + n];
    values[n] = ((folded >> 1) ^ -(folded & 1)) + (n < line ? 0 : values[n - line]);
  }
  return values;
}
