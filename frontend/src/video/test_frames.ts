/**
 * One small picture in every coding, with its left half in one colour and its right half in
 * another. Decoding it shows whether a browser really supports the coding, with the right colours.
 */
const bytes = (base64: string): Uint8Array<ArrayBuffer> =>
  Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));

export type Rgb = readonly [number, number, number];
export const testLeft: Rgb = [200, 80, 40];
export const testRight: Rgb = [30, 120, 210];

/** 64 x 64, one key frame in Annex B with its parameter sets: baseline, BT.709, studio range. */
export const testH264 = {
  decoder: "avc1.42C00A",
  side: 64,
  data: () =>
    bytes(
      "AAAAAWdCwAraEJpqAgICgAAAAwCAAAAZR4kTUAAAAAFozgO8gAAAAWWIhDr//8EUUAAQTfHAAEO2OAAI5En4f/4IooABDxwABKsjgACanJ1109dd" +
        "dPXXXT14",
    ),
};

/** 16 x 16, baseline, without chroma subsampling. */
export const testJpeg = {
  side: 16,
  data: () =>
    bytes(
      "/9j/2wBDAAgEBAQEBAUFBQUFBQYGBgYGBgYGBgYGBgYHBwcICAgHBwcGBgcHCAgICAkJCQgICAgJCQoKCgwMCwsODg4RERT/xABOAAEBAQAAAAAAAA" +
        "AAAAAAAAAABAUBAQEBAAAAAAAAAAAAAAAAAAAGBxABAAAAAAAAAAAAAAAAAAAAABEBAAAAAAAAAAAAAAAAAAAAAP/AABEIABAAEAMBEgACEgADEgD/" +
        "2gAMAwEAAhEDEQA/AM4S4vxONkGGD//Z",
    ),
};

/** 64 x 64, one intra picture with its sequence header: BT.601, studio range. */
export const testMpeg1 = {
  side: 64,
  data: () =>
    bytes(
      "AAABswQAQBX//+AYAAABuAAIAEAAAAEAAA//+AAAAQET59KUvm77i5SlIi6KUpfrN+M3KUpEQAAAAQIT59KUvm77i5SlIi6KUpfrN+M3KUpEXfSl" +
        "L8mv2a5SlIi6KUpfrN+M3KUpEQAAAAEEE+fSlL5t77i5SlIeLopSl+s34zcpSkRA",
    ),
};

/** 4 x 2, lossless. */
export const testStill = {
  width: 4,
  height: 2,
  png: () =>
    bytes(
      "iVBORw0KGgoAAAANSUhEUgAAAAQAAAACCAIAAADwyuo0AAAACXBIWXMAAAAAAAAAAQCEeRdzAAAAFUlEQVR4nGM4EaABRHIVl4CIAZkDAIgKCqE9" +
        "D1KZAAAAAElFTkSuQmCC",
    ),
  webp: () => bytes("UklGRiIAAABXRUJQVlA4TBYAAAAvA0AAAA9wFKhbIR9Fdf5jCWWI6H8A"),
};
