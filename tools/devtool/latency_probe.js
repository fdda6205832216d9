// Runs in the viewer's page before its own scripts and after page_wire.js (benches/latency.py).
// Records when an input happened, when the messages that it caused passed the socket, and when the
// canvas showed it. Only reads the stream and the pixels, so that the page behaves as usual. All
// times are the page's, in milliseconds.
(() => {
  const probe = { inputs: [], frames: [], acks: {}, codec: 0 };
  window.diaphaneProbe = probe;

  const each_field = window.eachProtobufField;
  const numbers_of = (bytes, names) => {
    const found = Object.fromEntries(Object.values(names).map((name) => [name, 0]));
    each_field(bytes, (number, value) => {
      if (number in names && typeof value === "number") found[names[number]] = value;
    });
    return found;
  };

  let moved = null;
  let last = "";
  const moves = (event) => {
    const at = `${event.clientX} ${event.clientY}`;
    if (at !== last) moved ??= { event: event.timeStamp }; // the browser reports a move twice: raw, and with the next frame
    last = at;
  };
  for (const kind of ["pointerrawupdate", "pointermove"]) addEventListener(kind, moves, { capture: true });

  const heard = (bytes) => {
    each_field(bytes, (kind, body) => {
      if (kind === 1) probe.codec = numbers_of(body, { 3: "codec" }).codec;
      if (kind !== 2) return;
      const frame = numbers_of(body, { 1: "codec", 3: "epoch", 4: "seq", 5: "input_seq", 8: "width", 9: "height", 10: "render_us", 11: "encode_us" });
      probe.frames.push({ ...frame, bytes: body.length, arrived: performance.now() });
    });
  };
  const said = (bytes) => {
    each_field(bytes, (kind, body) => {
      if (kind === 2 && moved) {
        const { input_seq } = numbers_of(body, { 1: "input_seq" });
        probe.inputs.push({ input_seq, ...moved, sent: performance.now(), shown: 0 });
        moved = null;
      } else if (kind === 3) {
        const ack = numbers_of(body, { 1: "seq", 3: "received_us", 4: "decoded_us", 5: "presented_us" });
        probe.acks[ack.seq] = ack;
      }
    });
  };
  const Native = window.WebSocket;
  window.WebSocket = class extends Native {
    constructor(...given) {
      super(...given);
      Object.assign(probe, { inputs: [], frames: [], acks: {} });
      this.addEventListener("message", ({ data }) => heard(new Uint8Array(data)));
    }
    send(data) {
      said(data);
      super.send(data);
    }
  };

  // renderd/encode/frame_mark.h: 40 cells along the top edge; white, black, 24 bits, 8 bits of checksum, 6 black.
  const cells = 40;
  const marked_input = (context, { width }) => {
    const size = width / cells;
    const row = context.getImageData(0, Math.floor(size / 2), width, 1).data;
    const light = (n) => row[4 * Math.floor((n + 0.5) * size) + 1] > 127;
    if (!light(0) || light(1)) return null;
    const byte = (first) => Array.from({ length: 8 }, (_, n) => light(first + n)).reduce((sum, on) => 2 * sum + Number(on), 0);
    const [high, middle, low, check] = [2, 10, 18, 26].map(byte);
    return (high ^ middle ^ low) === check ? (high << 16) | (middle << 8) | low : null;
  };

  // Before each screen refresh, reads what the canvas is about to show.
  let open = 0; // inputs before this one have been seen
  const look = () => {
    requestAnimationFrame(look);
    const canvas = document.querySelector("canvas[data-samples]");
    if (open > probe.inputs.length) open = 0; // another connection
    if (!canvas || open >= probe.inputs.length) return;
    const seen = marked_input(canvas.getContext("2d"), canvas);
    const now = performance.now();
    while (seen !== null && open < probe.inputs.length && (probe.inputs[open].input_seq & 0xffffff) <= seen) probe.inputs[open++].shown = now;
  };
  requestAnimationFrame(look);
})();
