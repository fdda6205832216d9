// Put into a page before its own scripts, after tools/devtool/page_wire.js: what its stream said, for the tests of test_stream.py.
(() => {
  const heard = { tiles: {}, codecs: {}, epoch: 0, frame: null, coarseness: 0, spoil: false };
  window.heardStills = heard;

  const fields = window.eachProtobufField;
  const names = { 1: "epoch", 2: "tile", 3: "tiles", 4: "x", 5: "y", 6: "width", 7: "height", 9: "hash", 12: "samples" };
  const frame_names = { 1: "codec", 3: "epoch", 6: "samples", 8: "width", 9: "height", 12: "data", 13: "denoised", 15: "quality" };

  // By how much quantising the mean of a block can change the mean of blue, the most affected channel: half a step of luma, and of Cb
  // by its factor. Luma is table 0 of a JPEG, chroma table 1, and the first step of each is that of 8 times the mean.
  const coarseness = (jpeg) => {
    const steps = [];
    for (let at = 2; at + 4 < jpeg.length && jpeg[at] === 0xff && jpeg[at + 1] !== 0xda; at += 2 + jpeg[at + 2] * 256 + jpeg[at + 3])
      if (jpeg[at + 1] === 0xdb)
        for (let table = at + 4; table < at + 2 + jpeg[at + 2] * 256 + jpeg[at + 3]; table += 65) steps[jpeg[table] & 15] = jpeg[table + 1];
    return steps[0] / 16 + (1.772 * steps[1]) / 16;
  };
  const hear = (data) =>
    fields(new Uint8Array(data), (kind, body) => {
      if (kind === 2) {
        const frame = {};
        fields(body, (n, value) => n in frame_names && (frame[frame_names[n]] = value));
        heard.codecs[frame.codec] = true;
        heard.coarseness = frame.codec === 1 ? coarseness(frame.data) : 0;
        delete frame.data;
        heard.frame = frame;
      }
      if (kind !== 3) return;
      const still = { tile: 0, x: 0, y: 0 };
      fields(body, (n, value) => n in names && (still[names[n]] = value));
      if (still.epoch > heard.epoch) Object.assign(heard, { epoch: still.epoch, tiles: {} });
      heard.tiles[still.tile] = still;
      if (heard.spoil) still.hash[0] ^= 1; // the same bytes that the page will read
    });
  const Native = window.WebSocket;
  window.WebSocket = class extends Native {
    constructor(...given) {
      super(...given);
      this.addEventListener("message", ({ data }) => hear(data));
    }
  };

  // The canvas as the last coded picture left it: looked at before each picture of the screen until the mark is there.
  heard.keepCoded = (canvas) => {
    let kept = "";
    heard.coded = () => kept;
    const small = new OffscreenCanvas(128, 128).getContext("2d", { willReadFrequently: true });
    small.imageSmoothingQuality = "high";
    const native = CanvasRenderingContext2D.prototype.putImageData;
    const keep = () => {
      small.drawImage(canvas, 0, 0, 128, 128);
      const rgba = small.getImageData(0, 0, 128, 128).data;
      let text = "";
      for (let i = 0; i < rgba.length; i += 4) text += String.fromCharCode(rgba[i], rgba[i + 1], rgba[i + 2]);
      kept = btoa(text);
    };
    CanvasRenderingContext2D.prototype.putImageData = function (image, x, y) {
      if (this.canvas === canvas && x === 0 && y === 0) keep(); // the first tile: what is there is the stream's
      return native.call(this, image, x, y);
    };
  };
})();
