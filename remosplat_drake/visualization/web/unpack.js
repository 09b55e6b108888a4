// Decompresses the page in this file, and replaces the document with it.
(async () => {
  const packed = document.getElementById("packed").textContent;
  const bytes = Uint8Array.from(atob(packed), (c) => c.charCodeAt(0));
  const stream = new Blob([bytes])
    .stream()
    .pipeThrough(new DecompressionStream("deflate"));
  const data = new Uint8Array(await new Response(stream).arrayBuffer());

  // For each k, the bytes k, k + stride, k + 2 stride, ... are stored together.
  const spread = (part, stride) => {
    const rows = Math.floor(part.length / stride);
    const whole = new Uint8Array(part);
    for (let k = 0, at = 0; k < stride; k++) {
      for (let row = 0; row < rows; row++) whole[row * stride + k] = part[at++];
    }
    return whole;
  };

  const text = new TextDecoder();
  let at = 4 + new DataView(data.buffer).getUint32(0, true);
  const parts = JSON.parse(text.decode(data.subarray(4, at))).map(
    ([size, stride]) => spread(data.subarray(at, (at += size)), stride),
  );
  window.remosplat = {
    part: (i) => parts[i],
    url: (i) => URL.createObjectURL(new Blob([parts[i]])),
  };
  document.open();
  document.write(text.decode(parts[0]));
  document.close();
})().catch((error) => {
  document.getElementById("wait").textContent =
    "This page needs a newer browser: " + error;
});
