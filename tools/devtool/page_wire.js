// A minimal Protobuf reader for the page's stream: calls `field(number, value)` for each field of a
// message, with a number for a varint and the bytes of a length-delimited field (a part of `bytes`,
// not a copy). Skips other fields.
window.eachProtobufField = (bytes, field) => {
  let at = 0;
  const varint = () => {
    let value = 0;
    for (let scale = 1; ; scale *= 128) {
      const byte = bytes[at++];
      value += (byte & 127) * scale;
      if (byte < 128) return value;
    }
  };
  while (at < bytes.length) {
    const key = varint();
    const number = Math.floor(key / 8);
    switch (key % 8) {
      case 0:
        field(number, varint());
        break;
      case 1:
        at += 8;
        break;
      case 2: {
        const length = varint();
        field(number, bytes.subarray(at, at + length));
        at += length;
        break;
      }
      case 5:
        at += 4;
        break;
      default:
        throw new Error("not Protobuf");
    }
  }
};
